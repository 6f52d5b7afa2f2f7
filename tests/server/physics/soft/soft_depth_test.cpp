// SPDX-License-Identifier: Apache-2.0
// Depth at which a sphere settles in a soft block (scene 29), for default and given cells.
#include <cstdio>

#include "known_gaps.h"
#include "server/physics/soft/settled_block.h"
#include "server/physics/soft/soft_depth.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

// The depth in cells of 12.5 mm. soft_depth_nightly_test halves them again.
double converged_m() {
  static const double depth_m = settled_depth_m(particle_block(0.00625, 0.0125), 90.0);
  return depth_m;
}

TEST(SoftDepth, SphereSettlesAtTheConvergedDepth) {
  for (const double rate : kRates_hz) {
    for (const double cell_width_m :
         gate_or_full<double>({0.0, 0.025}, {0.0, 0.0125, 0.015, 0.02, 0.025, 0.03})) {
      const double depth_m = settled_depth_m(particle_block(0.0125, cell_width_m), rate);
      // Wider than the contact; see ManySubstepsMatchElementsOfCellWidth.
      if (cell_width_m > 0.025)
        report_gap("soft.depth_of_wide_cells", std::abs(depth_m / converged_m() - 1.0));
      else
        EXPECT_NEAR(depth_m / converged_m(), 1.0, 0.1) << rate << " Hz, cells of " << cell_width_m;
    }
  }
  // Hertz on a half-space: d = (F (1 - nu²) / (4/3 E sqrt(R)))^(2/3) = 13 mm. The block is only four contact
  // radii deep and also sinks under its own weight.
  const double hertz = std::pow(kGravity * 0.91 / (4.0 / 3.0 * 2e4 * std::sqrt(0.05)), 2.0 / 3.0);
  EXPECT_NEAR(converged_m() / hertz, 1.0, 0.35);
}

// The converged depth compared with finite elements: a floor with friction is between a sliding and a glued
// one.
TEST(SoftDepth, ConvergedDepthMatchesFiniteElements) {
  const double held_m = settled_depth_m(SettledBlock{.element_m = 0.0125, .glued = true});
  const double sliding_m = settled_depth_m(SettledBlock{.element_m = 0.0125});
  std::printf("converged %.3f mm; finite elements %.3f held, %.3f sliding\n", 1e3 * converged_m(),
              1e3 * held_m, 1e3 * sliding_m);
  EXPECT_GT(converged_m(), 0.97 * held_m);
  EXPECT_LT(converged_m(), 1.03 * sliding_m);
}

// Cells wider than the contact (27 mm radius) are too stiff beneath it. With short steps the depth is that of
// finite elements as wide as the cells. At 4 substeps the pass leaves deformations of one or two cells too
// soft, which happens to balance the error.
TEST(SoftDepth, ManySubstepsMatchElementsOfCellWidth) {
  for (const double cell_width_m : {0.2 / 6, 0.025}) {
    const double held_m = settled_depth_m(SettledBlock{.element_m = cell_width_m, .glued = true});
    const double sliding_m = settled_depth_m(SettledBlock{.element_m = cell_width_m});
    const double depth_m = settled_depth_m(particle_block(0.0125, cell_width_m), 60.0, 32);
    std::printf("cells of %.1f mm: %.3f mm; finite elements %.3f held, %.3f sliding\n", 1e3 * cell_width_m,
                1e3 * depth_m, 1e3 * held_m, 1e3 * sliding_m);
    EXPECT_GT(depth_m, 0.95 * held_m);
    EXPECT_LT(depth_m, 1.05 * sliding_m);
    EXPECT_LT(sliding_m, 0.83 * converged_m());
  }
}

// Fifteen voxels along 0.2 m are 7.5 over 0.1 m. The outermost must still end at the faces.
TEST(SoftDepth, SphereSettlesOnUnevenlySampledBlock) {
  for (const double rate : kRates_hz) {
    EXPECT_NEAR(settled_depth_m(sampled_block(), rate) / converged_m(), 1.0, 0.1) << rate;
  }
}

// A pit has the same depth at any position, so only rolling resistance keeps a ball in place
// (cells_rolling_resistance.cpp).
TEST(SoftDepth, BallStaysWhereItIsPlaced) {
  for (const double rate : kRates_hz) {
    for (const double spacing_m :
         gate_or_full<double>({0.0, 0.025}, {0.0, 0.0125, 0.015, 0.02, 0.025, 0.03})) {
      for (const double loss_factor : gate_or_full<double>({0.1, 2.0}, {0.1, 0.3, 2.0})) {
        SCOPED_TRACE(testing::Message() << rate << " Hz, " << spacing_m << " m, " << loss_factor);
        World world = world_with(make_elastic_body, rate);
        world.add_collider(floor_plane(0.6));
        ElasticBodyDescription block = sampled_block(spacing_m);
        block.material.loss_factor = loss_factor;
        block.world_from_object.position_m = {0, 0.05, 0};
        ASSERT_TRUE(world.add_elastic(block));
        ASSERT_TRUE(world.add_ball(ball(2, {0, 0.15, 0}, 0.05, 1.0)));
        run_seconds(world, 10.0);
        const Vector3d at_m = body_state(world, 2).world_from_body.position_m;
        EXPECT_LT(std::hypot(at_m.x(), at_m.z()), spacing_m > 0.028 ? 0.03 : 0.012);
        EXPECT_NEAR(at_m.y(), 0.15 - converged_m(), spacing_m > 0.022 ? 0.009 : 0.003);
        EXPECT_TRUE(body_state(world, 2).asleep);
      }
    }
  }
}

}  // namespace
}  // namespace livegs

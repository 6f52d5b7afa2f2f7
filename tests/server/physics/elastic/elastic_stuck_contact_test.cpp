// SPDX-License-Identifier: Apache-2.0
// Soft bodies that start scrambled: around a bar with points on either side of it, or on a floor after
// plastic flow.
#include "known_gaps.h"
#include "scenes/soft_fixtures.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

ElasticBodyDescription scrambled_block(uint64_t seed) {
  ElasticBodyDescription block = soft_block(1, Vector3d::Constant(0.1), 0.1, 1.5e5, 0.02, 0.45);
  block.cells.scramble = seed;
  return block;
}

double elastic_j(const World& world) { return world.elastic_body(1)->energy(Vector3d::Zero()).elastic_j; }

// Contacts on all sides of a bar can trap a scrambled block and its elastic energy. In the remaining cases
// the bar penetrates the block, which compresses it.
TEST(Impaled, BodyStretchedAroundABarSeparates) {
  for (const double rate : kRates_hz) {
    const int seeds = seed_count(10);
    int calm = 0, free = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      WorldSettings settings;
      settings.rate_hz = rate;
      settings.gravity_m_s2.setZero();
      settings.sleep = false;  // sleep would stop motion below 20 mm/s
      World world(settings);
      ASSERT_TRUE(world.add_elastic(scrambled_block(static_cast<uint64_t>(seed))));
      ASSERT_TRUE(world.add_rigid(box_body(2, {0.02, 0.6, 0.02}, 5.0)));
      run_seconds(world, 3.0);
      EXPECT_LT(elastic_j(world), 4.0) << rate << ' ' << seed;
      calm += elastic_j(world) < 1.5;
      free += elastic_j(world) < 1e-3;
      EXPECT_LT(world.energy().linear_momentum.norm(), 1e-7) << rate << ' ' << seed;
    }
    report_gap("impaled.calm_share", static_cast<double>(calm) / seeds);
    EXPECT_GE(50 * calm, 49 * seeds) << rate;  // all of the gate's seeds
    report_gap("impaled.free_share", static_cast<double>(free) / seeds);
    EXPECT_GE(2 * free, seeds) << rate;
  }
}

// The remaining energy is stress between cells that flowed separately.
TEST(Impaled, PlasticTangleRecoversOnAFloor) {
  for (const double rate : kRates_hz) {
    for (int seed = 1; seed <= seed_count(3); ++seed) {
      World world = world_with(make_elastic_body, rate);
      world.add_collider(floor_plane(0.6));
      ElasticBodyDescription block = scrambled_block(static_cast<uint64_t>(seed));
      block.material.plasticity = 0.3;
      block.world_from_object.position_m = {0, 0.1, 0};
      ASSERT_TRUE(world.add_elastic(block));
      run_seconds(world, 4.0);
      EXPECT_LT(elastic_j(world), 1.0) << rate << ' ' << seed;
    }
  }
}

}  // namespace
}  // namespace livegs

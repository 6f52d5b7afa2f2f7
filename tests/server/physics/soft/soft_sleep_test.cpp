// SPDX-License-Identifier: Apache-2.0
// Scene 31 for elastic bodies. A sleeping pile rests where it would rest awake and wakes at a poke. Bodies
// with their own substeps rest where they would with the substeps of the stiffest.
#include <algorithm>

#include "scenes/soft_fixtures.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

constexpr uint32_t kPiled = 6;
constexpr double kSettled_s = 3.5;

// A pyramid of three, two and one blocks of 0.1 x 0.06 x 0.1 m, released 1 mm above each other.
World pile(double rate, bool sleep) {
  WorldSettings settings;
  settings.rate_hz = rate;
  settings.sleep = sleep;
  World world(settings);
  world.add_collider(floor_plane(0.6));
  uint32_t id = 1;
  for (int row = 0; row < 3; ++row) {
    for (int i = 0; i < 3 - row; ++i) {
      ElasticBodyDescription block = soft_block(id++, {0.1, 0.06, 0.1}, 0.4, 3e4, 0.02);
      block.world_from_object.position_m = {0.11 * (i - 0.5 * (2 - row)), 0.031 + 0.061 * row, 0.0};
      EXPECT_TRUE(world.add_elastic(block));
    }
  }
  return world;
}

bool all_asleep(const World& world) {
  for (uint32_t id = 1; id <= kPiled; ++id) {
    if (!world.elastic_body(id)->asleep()) return false;
  }
  return true;
}

TEST(SoftSleep, PileRestsWhereItWouldRestAwake) {
  for (const double rate : kRates_hz) {
    World sleeping = pile(rate, true), waking = pile(rate, false);
    for (World* world : {&sleeping, &waking}) run_seconds(*world, kSettled_s);
    EXPECT_TRUE(all_asleep(sleeping)) << rate;
    double apart_m = 0;
    for (uint32_t id = 1; id <= kPiled; ++id) {
      const auto one = sleeping.elastic_body(id)->particles(), other = waking.elastic_body(id)->particles();
      for (size_t i = 0; i < one.size(); ++i) {
        apart_m = std::max(apart_m, (one[i].position_m - other[i].position_m).norm());
      }
    }
    EXPECT_LT(apart_m, 1e-3) << rate;
  }
}

TEST(SoftSleep, PokeWakesThePileAtOnce) {
  for (const double rate : kRates_hz) {
    World world = pile(rate, true);
    run_seconds(world, kSettled_s);
    ASSERT_TRUE(all_asleep(world)) << rate;
    world.set_force(1, kPiled, {Vector3d::Zero(), {0.1 * rate, 0, 0}});  // 0.1 N s in one tick
    world.step();
    for (uint32_t id = 1; id <= kPiled; ++id)
      EXPECT_FALSE(world.elastic_body(id)->asleep()) << id << " " << rate;
  }
}

// A stiff cube on its own and one on a soft block. The second makes the block take its substeps too.
TEST(SoftSleep, OwnSubstepsGiveTheSameRestPositions) {
  const auto settled = [](double rate, int substeps, std::array<int, 3>& taken) {
    WorldSettings settings;
    settings.rate_hz = rate;
    settings.substeps = substeps;
    World world(settings);
    world.add_collider(floor_plane(0.6));
    ElasticBodyDescription block = soft_block(1, {0.3, 0.1, 0.3}, 4.5, 2e4, 0.02);
    block.world_from_object.position_m = {0, 0.051, 0};
    ElasticBodyDescription cube = soft_block(2, {0.1, 0.1, 0.1}, 0.5, 1e6, 0.02);
    cube.world_from_object.position_m = {0.02, 0.155, 0};
    ElasticBodyDescription alone = soft_block(3, {0.1, 0.1, 0.1}, 0.5, 1e6, 0.02);
    alone.world_from_object.position_m = {1, 0.055, 0};
    for (const auto& body : {block, cube, alone}) EXPECT_TRUE(world.add_elastic(body));
    for (uint32_t id = 1; id <= 3; ++id) taken[id - 1] = world.elastic_body(id)->accuracy().substeps;
    run_seconds(world, kSettled_s);
    std::array<std::vector<ParticleState>, 3> states;
    for (uint32_t id = 1; id <= 3; ++id) states[id - 1] = world.elastic_body(id)->particles();
    return states;
  };
  for (const double rate : kRates_hz) {
    std::array<int, 3> own, all;
    const auto few = settled(rate, 4, own);
    ASSERT_LT(own[0], own[1]) << rate;
    const auto many = settled(rate, own[1], all);
    for (int body = 0; body < 3; ++body) {
      EXPECT_EQ(all[body], own[1]) << rate;
      double apart_m = 0;
      for (size_t i = 0; i < few[body].size(); ++i) {
        apart_m = std::max(apart_m, (few[body][i].position_m - many[body][i].position_m).norm());
      }
      EXPECT_LT(apart_m, 1e-3) << "body " << body << ", " << rate << " Hz";
    }
  }
}

}  // namespace
}  // namespace livegs

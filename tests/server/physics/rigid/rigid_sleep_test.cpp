// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "server/physics/rigid/rigid_structures.h"

// Scene 31: sleeping bodies rest where they would rest awake, wake at a poke, and cost almost nothing.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

// Twenty cubes, each slightly offset from the one below.
void add_uneven_stack(World& world) {
  world.add_collider(floor_plane(0.6));
  for (uint32_t i = 0; i < 20; ++i) {
    add_box(world, i + 1, Vector3d::Constant(0.1), 1.0, at(0.001 * (i % 3), 0.05 + 0.1 * i), 0.6);
  }
}

struct Built {
  const char* name;
  std::function<void(World&)> add;
  double seconds;  // the structure must be asleep by then
};
const Built kBuilt[] = {
    {"stack", add_uneven_stack, 6.0}, {"arch", add_arch, 6.0}, {"card house", add_card_house, 6.0}};

TEST(RigidSleep, RestPosesDoNotDependOnSleep) {
  for (const double rate : kRates_hz) {
    for (const Built& built : kBuilt) {
      std::vector<BodyState> rest[2];
      for (const bool sleep : {false, true}) {
        WorldSettings settings;
        settings.rate_hz = rate;
        settings.sleep = sleep;
        World world(settings);
        built.add(world);
        run_seconds(world, built.seconds);
        rest[sleep] = world.bodies();
      }
      double apart_m = 0;
      for (size_t i = 0; i < rest[0].size(); ++i) {
        EXPECT_TRUE(rest[1][i].asleep) << built.name << " " << rate;
        apart_m = std::max(
            apart_m, (rest[0][i].world_from_body.position_m - rest[1][i].world_from_body.position_m).norm());
      }
      EXPECT_LT(apart_m, 1e-3) << built.name << " " << rate;
    }
  }
}

TEST(RigidSleep, PokeWakesTheWholeIslandAtOnce) {
  for (const double rate : kRates_hz) {
    for (const Built& built : kBuilt) {
      World world = world_at(rate, 4);
      built.add(world);
      constexpr uint32_t kElsewhere = 99;
      add_box(world, kElsewhere, Vector3d::Constant(0.1), 0.5, at(2, 0.05), 0.6);
      run_seconds(world, built.seconds);
      for (const BodyState& state : world.bodies())
        ASSERT_TRUE(state.asleep) << built.name << " " << state.object_id;
      world.set_force(1, 3, {Vector3d::Zero(), {0.1 * rate, 0, 0}});  // 0.1 N s in one tick
      world.step();
      for (const BodyState& state : world.bodies()) {
        EXPECT_EQ(state.asleep, state.object_id == kElsewhere)
            << built.name << " " << rate << " " << state.object_id;
      }
    }
  }
}

TEST(RigidSleep, PokedStackSleepsAgain) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    add_stack(world, 5, 0.1, 0.5);
    run_seconds(world, 2.0);
    world.set_force(1, 3, {Vector3d::Zero(), {0.1 * rate, 0, 0}}, 1.0 / rate);
    world.step();
    run_seconds(world, 3.0);
    for (const BodyState& state : world.bodies()) EXPECT_TRUE(state.asleep) << state.object_id;
    // 0.1 N s gives one box 0.2 m/s. The friction above and below stops it within millimetres.
    EXPECT_NEAR(body_state(world, 5).world_from_body.position_m.y(), 0.45, 1e-3);
  }
}

// Two hundred stacks of five boxes. The smallest step time counts, awake and asleep.
TEST(RigidSleep, SleepingBodiesCostUnderOnePercentOfAwake) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.6));
    for (uint32_t i = 0; i < 1000; ++i) {
      const uint32_t stack = i / 5;
      add_box(world, i + 1, Vector3d::Constant(0.1), 0.5,
              at(0.3 * (stack % 15), 0.05 + 0.1 * (i % 5), 0.3 * (stack / 15)), 0.6);
    }
    const auto all_asleep = [&] {
      const std::vector<BodyState> bodies = world.bodies();
      return std::all_of(bodies.begin(), bodies.end(), [](const BodyState& body) { return body.asleep; });
    };
    double awake_ms = 1e9, asleep_ms = 1e9;
    while (world.tick() < 20 || (world.tick() < 120 && !all_asleep())) {
      world.step();
      if (world.tick() <= 20) awake_ms = std::min(awake_ms, world.last_times().total_ms);
    }
    ASSERT_TRUE(all_asleep());
    for (int i = 0; i < 50; ++i) {
      world.step();
      asleep_ms = std::min(asleep_ms, world.last_times().total_ms);
    }
    EXPECT_LT(asleep_ms / awake_ms, 0.01) << asleep_ms << " of " << awake_ms << " ms";
  }
}

}  // namespace
}  // namespace livegs

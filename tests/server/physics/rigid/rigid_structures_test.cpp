// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "known_gaps.h"
#include "server/physics/rigid/rigid_structures.h"

// Structures of boxes and wedges that must stay standing, at 4 substeps.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

// The largest distance of any body from its start, and whether all bodies sleep.
struct Settled {
  double strayed_m = 0;
  bool asleep = true;
};
Settled settled_after(World& world, double seconds) {
  const std::vector<BodyState> start = world.bodies();
  run_seconds(world, seconds);
  Settled settled;
  const std::vector<BodyState> end = world.bodies();
  for (size_t i = 0; i < end.size(); ++i) {
    settled.strayed_m = std::max(
        settled.strayed_m, (end[i].world_from_body.position_m - start[i].world_from_body.position_m).norm());
    settled.asleep = settled.asleep && end[i].asleep;
  }
  return settled;
}

TEST(RigidStructures, StackOfTwentyStands) {
  for (const double rate : kRates_hz) {
    for (const auto& [size, sleep] : gate_or_full<std::pair<double, bool>>(
             {{0.1, true}, {1.0, false}}, {{0.1, true}, {0.1, false}, {1.0, true}, {1.0, false}})) {
      WorldSettings settings;
      settings.rate_hz = rate;
      settings.sleep = sleep;
      World world(settings);
      add_stack(world, 20, size, 1000.0 * size * size * size);
      run_seconds(world, 5.0);
      for (const BodyState& state : world.bodies()) EXPECT_EQ(state.asleep, sleep);  // scene 13: by 5 s
      run_seconds(world, 25.0);
      const Vector3d top = body_state(world, 20).world_from_body.position_m;
      EXPECT_GT(top.y(), 19.5 * size * 0.99) << size << " m at " << rate << " Hz";  // sag under 1 %
      EXPECT_LT(std::hypot(top.x(), top.z()), 0.01) << size << " m at " << rate << " Hz";
    }
  }
}

TEST(RigidStructures, HeavyBoxRestsOnLightBox) {
  struct Case {
    double ratio, size_m, bar;
    int substeps;
  };
  // Scene 14 at 1 m and at the VR size of 0.1 m. Required: 1 % at 1:10, 5 % at 1:100.
  const Case cases[] = {{10, 1, 0.002, 4},     {10, 0.1, 0.002, 4},    {100, 1, 0.002, 4},
                        {100, 0.1, 0.002, 4},  {1000, 1, 0.002, 4},    {1000, 0.1, 0.002, 4},
                        {1000, 1, 0.002, 16},  {1000, 0.1, 0.002, 16}, {1000, 0.1, 0.002, 1},
                        {10000, 0.1, 0.003, 4}};
  for (const double rate : kRates_hz) {
    for (const Case& c : cases) {
      World world = world_at(rate, c.substeps);
      world.add_collider(floor_plane(0.6));
      const double mass = 1000.0 * c.size_m * c.size_m * c.size_m;
      add_box(world, 1, Vector3d::Constant(c.size_m), mass, at(0, 0.5 * c.size_m), 0.6);
      add_box(world, 2, Vector3d::Constant(c.size_m), c.ratio * mass, at(0, 1.5 * c.size_m), 0.6);
      double lowest = 2.0;
      for (int i = 0; i < 10 * rate; ++i) {
        world.step();
        lowest = std::min(lowest, body_state(world, 2).world_from_body.position_m.y() / c.size_m);
      }
      EXPECT_LT(1.5 - lowest, c.bar) << "1:" << c.ratio << " of " << c.size_m << " m at " << rate << " Hz";
    }
  }
}

// Stacks of up to 20 boxes neither sink nor topple: the steps follow from the weight on each contact
// (step_plan.cpp), and no substep is longer than kMaxSubstep_s.
TEST(RigidStructures, StacksStandAtAnyRate) {
  struct Setting {
    double rate_hz;
    int substeps;
  };
  for (const Setting& setting : {Setting{1, 1}, {5, 1}, {10, 2}, {30, 1}, {60, 1}, {90, 4}}) {
    for (const int boxes : {1, 5, 20}) {
      SCOPED_TRACE(::testing::Message()
                   << boxes << " boxes, " << setting.rate_hz << " Hz, " << setting.substeps << " substeps");
      World world = world_at(setting.rate_hz, setting.substeps);
      add_stack(world, static_cast<uint32_t>(boxes), 0.2, 4.0);
      const Settled settled = settled_after(world, 10.0);
      EXPECT_LT(settled.strayed_m, 0.01 * 0.2 * boxes);
      EXPECT_TRUE(settled.asleep);
    }
  }
}

// Books of 30 mm and 0.3 kg under a cube of 30 and 100 times their mass, which must hardly sink. Such mass
// ratios take shorter substeps (step_plan.cpp).
TEST(RigidStructures, HeavyCubeRestsOnLightBooks) {
  constexpr double kThick_m = 0.03, kBook_kg = 0.3, kSize_m = 0.15;
  for (const double rate : kRates_hz) {
    for (const double ratio : {30.0, 100.0}) {
      for (const uint32_t books : {3u, 5u}) {
        SCOPED_TRACE(::testing::Message() << books << " books, 1:" << ratio << ", " << rate << " Hz");
        World world = world_at(rate, 4);
        world.add_collider(floor_plane(0.6));
        for (uint32_t i = 0; i < books; ++i)
          add_box(world, i + 1, {0.2, kThick_m, 0.15}, kBook_kg, at(0, (i + 0.5) * kThick_m), 0.5);
        const double laid_m = books * kThick_m + 0.5 * kSize_m;
        add_box(world, books + 1, Vector3d::Constant(kSize_m), ratio * kBook_kg, at(0.01, laid_m, 0.01), 0.5);
        double lowest_m = laid_m;
        for (int i = 0; i < 5 * rate; ++i) {
          world.step();
          lowest_m = std::min(lowest_m, body_state(world, books + 1).world_from_body.position_m.y());
        }
        report_gap("structures.book_pile_sinks", (laid_m - lowest_m) / (books * kThick_m));
        for (uint32_t i = 1; i <= books; ++i) {
          const BodyState book = body_state(world, i);
          EXPECT_LT(std::hypot(book.world_from_body.position_m.x(), book.world_from_body.position_m.z()),
                    5e-4)
              << i;
          EXPECT_TRUE(book.asleep) << i;
        }
      }
    }
  }
}

TEST(RigidStructures, PyramidComesToRest) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.6));
    uint32_t id = 1;
    for (int row = 0; row < 10; ++row) {
      for (int i = 0; i < 10 - row; ++i) {
        add_box(world, id++, Vector3d::Constant(0.1), 1.0,
                at((i - 0.5 * (9 - row)) * 0.105, 0.05 + 0.1 * row), 0.6);
      }
    }
    const Settled settled = settled_after(world, 5.0);
    EXPECT_TRUE(settled.asleep);
    EXPECT_LT(settled.strayed_m, 1e-3);
  }
}

// Ten boxes, each half inside its neighbours. Without gravity all speed comes from the separation.
TEST(RigidStructures, HalfOverlappedBoxesSeparateSlowly) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    for (const double size : {0.1, 1.0}) {
      World world = world_at(rate, 4, Vector3d::Zero());
      for (uint32_t i = 0; i < 10; ++i) {
        add_box(world, i + 1, Vector3d::Constant(size), 1000 * size * size * size, at(0, 0.5 * i * size),
                0.6);
      }
      double fastest = 0.0;
      for (int i = 0; i < 4 * rate; ++i) {
        world.step();
        for (const BodyState& state : world.bodies()) fastest = std::max(fastest, state.velocity_m_s.norm());
      }
      EXPECT_LT(fastest, 3.0) << size;  // scene 19
      for (uint32_t i = 1; i < 10; ++i) {
        const Vector3d between = body_state(world, i + 1).world_from_body.position_m -
                                 body_state(world, i).world_from_body.position_m;
        EXPECT_GT(between.norm(), 0.99 * size) << i;
      }
    }
  }
}

// Scene 17: 30 s, with and without sleep.
void expect_stands(const std::function<void(World&)>& add) {
  for (const double rate : kRates_hz) {
    for (const bool sleep : {true, false}) {
      SCOPED_TRACE(::testing::Message() << rate << " Hz, may sleep: " << sleep);
      WorldSettings settings;
      settings.rate_hz = rate;
      settings.sleep = sleep;
      World world(settings);
      add(world);
      const Settled settled = settled_after(world, 30.0);
      EXPECT_LT(settled.strayed_m, 5e-3);
      EXPECT_EQ(settled.asleep, sleep);
    }
  }
}

// A half circle of wedges on two blocks. Thickness over radius is 0.3, far above the required 0.107 (Heyman
// 1969).
TEST(RigidStructures, ArchStands) { expect_stands(add_arch); }

TEST(RigidStructures, CardHouseStands) { expect_stands(add_card_house); }

}  // namespace
}  // namespace livegs

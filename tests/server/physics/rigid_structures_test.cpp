// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/convex_hull.h"
#include "server/physics/rigid_fixtures.h"

// Things built of boxes and wedges that should stand, at 4 substeps of 60 and 90 Hz.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

void add_box(World& world, uint32_t id, const Vector3d& size_m, double mass_kg, const Pose& pose, double friction) {
  auto box = box_body(id, size_m, mass_kg);
  box.material.friction = friction;
  box.world_from_object = pose;
  ASSERT_TRUE(world.add_rigid(box));
}

Pose at(double x, double y, double z = 0.0, double lean_rad = 0.0) {
  return {{x, y, z}, Eigen::Quaterniond(Eigen::AngleAxisd(-lean_rad, Vector3d::UnitZ()))};
}

// How far any body is from where it started, and whether all of them sleep.
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
  for (const double rate : {60.0, 90.0}) {
    for (const double size : {0.1, 1.0}) {
      World world = world_at(rate, 4);
      world.add_collider(floor_plane(0.6));
      for (uint32_t i = 0; i < 20; ++i) {
        add_box(world, i + 1, Vector3d::Constant(size), 1000.0 * size * size * size, at(0, (0.5 + i) * size), 0.6);
      }
      run_seconds(world, 5.0);
      for (const BodyState& state : world.bodies()) EXPECT_TRUE(state.asleep);  // scene 13: by 5 s
      run_seconds(world, 25.0);
      const Vector3d top = body_state(world, 20).world_from_body.position_m;
      EXPECT_GT(top.y(), 19.5 * size * 0.99) << size << " m at " << rate << " Hz";  // sag under 1 %
      EXPECT_LT(std::hypot(top.x(), top.z()), 0.01) << size << " m at " << rate << " Hz";
    }
  }
}

TEST(RigidStructures, HeavyRestsOnLight) {
  struct Case {
    double ratio, size_m, bar;
    int substeps;
  };
  // Scene 14, with a hand's box of 10 cm beside the metre: its contacts sag ten times as far in parts of its size.
  // 1:1000 is for 16 substeps.
  const Case cases[] = {{10, 1, 0.01, 4},     {10, 0.1, 0.01, 4},  {100, 1, 0.05, 4},
                        {100, 0.1, 0.05, 4},  {1000, 1, 0.1, 16},  {1000, 0.1, 0.1, 16}};
  for (const double rate : {60.0, 90.0}) {
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

TEST(RigidStructures, PyramidComesToRest) {
  World world = world_at(60, 4);
  world.add_collider(floor_plane(0.6));
  uint32_t id = 1;
  for (int row = 0; row < 10; ++row) {
    for (int i = 0; i < 10 - row; ++i) {
      add_box(world, id++, Vector3d::Constant(0.1), 1.0, at((i - 0.5 * (9 - row)) * 0.105, 0.05 + 0.1 * row), 0.6);
    }
  }
  const Settled settled = settled_after(world, 5.0);
  EXPECT_TRUE(settled.asleep);
  EXPECT_LT(settled.strayed_m, 1e-3);
}

// Ten boxes, each half inside its neighbours, without gravity so that all speed is the ejection's.
TEST(RigidStructures, HalfOverlappedBoxesPartSlowly) {
  for (const double size : {0.1, 1.0}) {
    World world = world_at(60, 4, Vector3d::Zero());
    for (uint32_t i = 0; i < 10; ++i) {
      add_box(world, i + 1, Vector3d::Constant(size), 1000 * size * size * size, at(0, 0.5 * i * size), 0.6);
    }
    double fastest = 0.0;
    for (int i = 0; i < 240; ++i) {
      world.step();
      for (const BodyState& state : world.bodies()) fastest = std::max(fastest, state.velocity_m_s.norm());
    }
    EXPECT_LT(fastest, 3.0) << size;  // scene 19
    for (uint32_t i = 1; i < 10; ++i) {
      const Vector3d between =
          body_state(world, i + 1).world_from_body.position_m - body_state(world, i).world_from_body.position_m;
      EXPECT_GT(between.norm(), 0.99 * size) << i;
    }
  }
}

// A half circle of wedges on two blocks: thickness over radius 0.3, far above the 0.107 it needs (Heyman 1969).
TEST(RigidStructures, ArchStands) {
  constexpr int kWedges = 9;
  constexpr double kInner = 0.35, kOuter = 0.5, kDepth = 0.2;
  for (const double rate : {60.0, 90.0}) {
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.8));
    for (int i = 0; i < kWedges; ++i) {
      std::vector<Vector3d> corners;
      for (const int end : {i, i + 1}) {
        const double angle = M_PI * end / kWedges;
        for (const double radius : {kInner, kOuter}) {
          for (const double z : {-0.5 * kDepth, 0.5 * kDepth}) {
            corners.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
          }
        }
      }
      auto wedge = body_of(static_cast<uint32_t>(i + 1), convex_hull(corners), 5.0);
      wedge.material.friction = 0.8;
      ASSERT_TRUE(world.add_rigid(wedge));
    }
    const Settled settled = settled_after(world, 30.0);
    EXPECT_LT(settled.strayed_m, 5e-3) << rate;  // scene 17
    EXPECT_TRUE(settled.asleep) << rate;
  }
}

// Three floors of leaning cards with flat ones between: 15 cards.
TEST(RigidStructures, CardHouseStands) {
  constexpr double kLength = 0.1, kThick = 0.002, kWidth = 0.06, kMass = 0.002, kFriction = 0.7;
  const double lean = radians(25);
  const double high = kLength * std::cos(lean) + kThick * std::sin(lean);  // of a floor of cards
  const double side = 0.5 * (kThick * std::cos(lean) + kLength * std::sin(lean));
  const double span = 4.0 * side + 0.001;
  for (const double rate : {60.0, 90.0}) {
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(kFriction));
    uint32_t id = 1;
    for (int floor = 0; floor < 3; ++floor) {
      const double foot = floor * (high + kThick);
      for (int i = 0; i < 3 - floor; ++i) {
        const double x = (i - 0.5 * (2 - floor)) * span;
        add_box(world, id++, {kThick, kLength, kWidth}, kMass, at(x - side, foot + 0.5 * high, 0, lean), kFriction);
        add_box(world, id++, {kThick, kLength, kWidth}, kMass, at(x + side, foot + 0.5 * high, 0, -lean), kFriction);
      }
      for (int i = 0; i < 2 - floor; ++i) {
        const double x = (i - 0.5 * (1 - floor)) * span;
        add_box(world, id++, {span - 0.0005, kThick, kWidth}, kMass, at(x, foot + high + 0.5 * kThick), kFriction);
      }
    }
    const Settled settled = settled_after(world, 30.0);
    EXPECT_LT(settled.strayed_m, 5e-3) << rate;  // scene 17
    EXPECT_TRUE(settled.asleep) << rate;
  }
}

TEST(RigidStructures, DominoesFallInOrder) {
  World world = world_at(60, 4);
  world.add_collider(floor_plane(0.5));
  for (uint32_t i = 0; i < 20; ++i) {
    const Vector3d foot(0.07 * i + 0.01, 0, 0);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(i == 0 ? -radians(10) : 0.0, Vector3d::UnitZ()));
    add_box(world, i + 1, {0.02, 0.2, 0.1}, 0.24, {foot + turn * Vector3d(-0.01, 0.1, 0), turn}, 0.5);
  }
  uint32_t fallen = 0;
  for (int i = 0; i < 240; ++i) {
    world.step();
    const auto states = world.bodies();
    for (uint32_t d = 0; d < 20; ++d) {
      const double upright = (states[d].world_from_body.orientation * Vector3d::UnitY()).y();
      if (upright > std::cos(radians(15))) continue;
      EXPECT_LE(d, fallen) << "fell before its neighbour";
      fallen = std::max(fallen, d + 1);
    }
  }
  EXPECT_EQ(fallen, 20u);
}

}  // namespace
}  // namespace livegs

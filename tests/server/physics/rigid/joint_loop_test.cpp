// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "core/math/rotation_between.h"
#include "known_gaps.h"
#include "scenes/rigid_fixtures.h"

// Closed joint loops with redundant or nearly redundant rows.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

double total_j(const World& world) {
  const BodyEnergy energy = world.energy();
  return energy.kinetic_j + energy.gravity_j;
}

struct LoopRun {
  double gained_j = 0, error_m = 0;
  bool finite = true;
};

// Runs a loop and records the energy above that of the start and the largest joint error.
LoopRun run_loop(World& world, double seconds) {
  LoopRun run;
  const double before = total_j(world);
  for (int i = 0; i < std::lround(seconds * world.settings().rate_hz); ++i) {
    world.step();
    const double now = total_j(world);
    run.finite = run.finite && std::isfinite(now);
    run.gained_j = std::max(run.gained_j, now - before);
    for (const JointState& joint : world.joints()) run.error_m = std::max(run.error_m, joint.error_m);
  }
  return run;
}

// A bar with a square section between two points.
RigidBodyDescription bar(uint32_t id, const Vector3d& from_m, const Vector3d& to_m, double mass_kg) {
  const Vector3d along = to_m - from_m;
  auto body = box_body(id, {0.9 * along.norm(), 0.02, 0.02}, mass_kg);
  body.world_from_object.position_m = 0.5 * (from_m + to_m);
  body.world_from_object.orientation = rotation_between(Vector3d::UnitX(), along);
  return body;
}

struct Frame {
  std::vector<Vector3d> nodes_m;
  std::vector<std::pair<size_t, size_t>> bars;
};

// Adds bars of 100 g. At each node the bars are joined to the first one there.
void add_frame(World& world, const Frame& frame) {
  std::vector<std::optional<uint32_t>> first(frame.nodes_m.size());
  uint32_t id = 0;
  for (const auto& [from, to] : frame.bars) {
    const Vector3d a = frame.nodes_m[from], b = frame.nodes_m[to];
    ASSERT_TRUE(world.add_rigid(bar(++id, a, b, 0.1)));
    const double half_m = 0.5 * (b - a).norm();
    for (const auto& [node, x] : {std::pair(from, -half_m), std::pair(to, half_m)}) {
      if (first[node]) {
        ASSERT_TRUE(world.add_ball_joint({id, first[node], Vector3d(x, 0, 0)}));
      } else {
        first[node] = id;
      }
    }
  }
}

Frame square_with_diagonals() {
  return {{{0, 0.3, 0}, {0.4, 0.3, 0}, {0.4, 0.7, 0}, {0, 0.7, 0}},
          {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}, {1, 3}}};
}

TEST(RigidLoop, SquareWithBothDiagonalsStaysJoined) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    world.add_collider(floor_plane());
    add_frame(world, square_with_diagonals());
    const LoopRun run = run_loop(world, 3.0);
    EXPECT_TRUE(run.finite);
    EXPECT_LT(run.gained_j, 1e-3 * 0.6 * kGravity);
    EXPECT_LT(run.error_m, 1e-3);
  }
}

// The diagonals overlap by 20 mm where they cross, and push each other.
TEST(RigidLoop, FramesAtRestWithoutGravityStayAtRest) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4, Vector3d::Zero());
    add_frame(world, square_with_diagonals());
    const LoopRun run = run_loop(world, 3.0);
    EXPECT_TRUE(run.finite);
    EXPECT_LT(run.gained_j, 1e-6);
    EXPECT_LT(run.error_m, 1e-4);
  }
}

// Five random nodes, all connected to each other: ten bars where nine would suffice. Bars that cross by
// chance push each other apart and gain energy.
TEST(RigidLoop, RandomTrussesStayJoined) {
  for (const double rate : kRates_hz) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE(std::to_string(rate) + " Hz, seed " + std::to_string(seed));
      std::mt19937 random(seed);
      const auto coordinate = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
      Frame frame;
      const bool flat = seed % 3 == 0;
      for (int i = 0; i < 5; ++i) {
        const double angle = 1.2566 * i, radius = 0.3 + 0.2 * coordinate();
        frame.nodes_m.push_back(
            {radius * std::cos(angle), 0.8 + radius * std::sin(angle), flat ? 0.0 : 0.5 * coordinate()});
      }
      for (size_t i = 0; i < 5; ++i) {
        for (size_t j = 0; j < i; ++j) frame.bars.emplace_back(j, i);
      }
      World world = world_at(rate, 4);
      world.add_collider(floor_plane());
      add_frame(world, frame);
      const LoopRun run = run_loop(world, 2.0);
      EXPECT_TRUE(run.finite);
      report_gap("loops.truss_gain", run.gained_j / (1.0 * kGravity));
      EXPECT_LT(run.error_m, 2e-3);
    }
  }
}

struct Bridge {
  int planks = 2;
  bool two_lines = false;  // joints at both edges of the planks
  bool hinges = false;
  double sag_rad = 0.0, load_kg = 0.0;
};

double add_bridge(World& world, const Bridge& bridge) {
  double x = 0.0, y = 1.0;
  std::vector<double> edges{0.0};
  if (bridge.two_lines) edges = {-0.1, 0.1};
  const auto join = [&](uint32_t id, std::optional<uint32_t> other, double end_m) {
    for (const double z : edges) {
      const Vector3d point(end_m, 0, z);
      ASSERT_TRUE(bridge.hinges ? world.add_hinge_joint({id, other, point, Vector3d::UnitZ()})
                                : world.add_ball_joint({id, other, point}));
    }
  };
  for (int i = 1; i <= bridge.planks; ++i) {
    const double turn = (2 * i <= bridge.planks ? -1.0 : 1.0) * bridge.sag_rad;
    auto plank = box_body(static_cast<uint32_t>(i), {0.095, 0.01, 0.2}, 0.1);
    plank.world_from_object.position_m = {x + 0.05 * std::cos(turn), y + 0.05 * std::sin(turn), 0};
    plank.world_from_object.orientation = Quaterniond(AngleAxisd(turn, Vector3d::UnitZ()));
    x += 0.1 * std::cos(turn);
    y += 0.1 * std::sin(turn);
    EXPECT_TRUE(world.add_rigid(plank));
    std::optional<uint32_t> other;
    if (i > 1) other = static_cast<uint32_t>(i - 1);
    join(static_cast<uint32_t>(i), other, -0.05);
  }
  join(static_cast<uint32_t>(bridge.planks), {}, 0.05);
  if (bridge.load_kg > 0.0) {
    auto load = box_body(100, {0.1, 0.1, 0.1}, bridge.load_kg);
    load.world_from_object.position_m = {0.5 * x, 1.2, 0};
    EXPECT_TRUE(world.add_rigid(load));
  }
  return 0.1 * bridge.planks + bridge.load_kg;
}

// Level and sagging bridges, unloaded and with a box dropped on them. In a level bridge only the compliance
// of the joints carries load.
TEST(RigidLoop, BridgesCarryBoxes) {
  for (const double rate : kRates_hz) {
    for (const Bridge& bridge : {Bridge{2, false, false, 0.0, 0.0},
                                 {2, false, false, 0.0, 1.0},
                                 {5, false, false, 0.0, 0.0},
                                 {8, false, false, 0.0, 0.0},
                                 {8, false, false, radians(1), 1.0},
                                 {8, true, false, radians(5), 5.0},
                                 {2, false, true, 0.0, 1.0},
                                 {2, false, true, 0.0, 0.0},
                                 {5, false, true, radians(2), 1.0},
                                 {15, true, false, 0.0, 1.0},
                                 {15, true, false, 0.0, 0.0}}) {
      SCOPED_TRACE(std::to_string(rate) + " Hz, " + std::to_string(bridge.planks) + " planks, sag " +
                   std::to_string(bridge.sag_rad) + ", load " + std::to_string(bridge.load_kg));
      World world = world_at(rate, 4);
      world.add_collider(floor_plane());
      const double mass_kg = add_bridge(world, bridge);
      const LoopRun run = run_loop(world, 3.0);
      EXPECT_TRUE(run.finite);
      EXPECT_LT(run.gained_j, 1e-3 * mass_kg * kGravity);
      EXPECT_LT(run.error_m, 5e-3);
    }
  }
}

// A box of 200 times a plank's mass opens joints for a moment but must not return energy.
TEST(RigidLoop, HeavyBoxesOnLevelBridgesGainNothing) {
  for (const double rate : kRates_hz) {
    for (const Bridge& bridge :
         {Bridge{2, false, false, 0.0, 20.0}, {2, true, false, 0.0, 20.0}, {15, true, false, 0.0, 20.0}}) {
      SCOPED_TRACE(std::to_string(rate) + " Hz, " + std::to_string(bridge.planks));
      World world = world_at(rate, 4);
      world.add_collider(floor_plane());
      const double mass_kg = add_bridge(world, bridge);
      const LoopRun run = run_loop(world, 3.0);
      EXPECT_TRUE(run.finite);
      EXPECT_LT(run.gained_j, 1e-2 * mass_kg * kGravity);
      EXPECT_LT(run.error_m, 5e-3);
    }
  }
}

// A force with an overflowing or NaN result stops the body it pushes. Other bodies fall normally.
TEST(RigidOutOfBounds, OverflowingMotionStopsTheBody) {
  for (const double force_n : {1e290, 1e308, std::numeric_limits<double>::quiet_NaN()}) {
    World world = world_at(60, 4);
    world.add_collider(floor_plane());
    auto pushed = box_body(1, {0.1, 0.1, 0.1}, 1.0);
    pushed.world_from_object.position_m = {0, 0.05, 0};
    ASSERT_TRUE(world.add_rigid(pushed));
    ASSERT_TRUE(world.add_ball(ball(2, {0, 3.0, 5.0})));
    world.set_force(1, 1, {{0.02, 0, 0}, {force_n, 0, 0}}, 5.0 / 60.0);
    for (int i = 0; i < 30; ++i) world.step();
    const BodyState state = body_state(world, 1);
    EXPECT_TRUE(state.world_from_body.position_m.allFinite());
    EXPECT_LT((state.world_from_body.position_m - Vector3d(0, 0.05, 0)).norm(), 0.01);
    EXPECT_LT(state.velocity_m_s.norm(), 0.1);
    EXPECT_NEAR(body_state(world, 2).world_from_body.position_m.y(), 3.0 - 0.5 * kGravity * 0.25, 0.01);
  }
}

}  // namespace
}  // namespace livegs

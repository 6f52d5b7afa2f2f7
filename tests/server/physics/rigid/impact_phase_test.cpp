// SPDX-License-Identifier: GPL-3.0-or-later
// Impacts that pass along rows of touching bodies, against closed forms.
#include "physics/rigid/contact/impact_phase.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "rates.h"
#include "scenes/rigid_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

constexpr double kRadius_m = 0.05, kSpeed_m_s = 2.0;

BallDescription smooth_ball(uint32_t id, const Vector3d& position_m, double restitution) {
  BallDescription description = ball(id, position_m, kRadius_m, 1.0);
  description.restitution = restitution;
  description.friction = 0.0;
  return description;
}

// A ball hits a row of balls `gap_m` apart. Speeds after it, the first ball first.
std::vector<double> speeds_of_cradle(int row, double gap_m, double restitution, double rate, int substeps) {
  World world = world_at(rate, substeps, Vector3d::Zero());
  for (int i = 0; i < row; ++i) {
    EXPECT_TRUE(world.add_ball(
        smooth_ball(static_cast<uint32_t>(i + 2), {(2 * kRadius_m + gap_m) * i, 0, 0}, restitution)));
  }
  BallDescription first = smooth_ball(1, {-0.5, 0, 0}, restitution);
  first.velocity_m_s = {kSpeed_m_s, 0, 0};
  EXPECT_TRUE(world.add_ball(first));
  run_seconds(world, 0.5);
  std::vector<double> speeds;
  for (int i = 0; i <= row; ++i)
    speeds.push_back(body_state(world, static_cast<uint32_t>(i + 1)).velocity_m_s.x());
  return speeds;
}

// Equal balls exchange their velocities in turn: the last one leaves with the speed of the first.
TEST(Impacts, CradleOfTouchingBallsPassesTheSpeedToTheLast) {
  for (const double rate : kRates_hz) {
    for (const int substeps : {1, 4, 16}) {
      for (const int row : {1, 2, 5, 12}) {
        for (const double gap_m : {0.0, 1e-3}) {
          SCOPED_TRACE(::testing::Message() << row << " balls, gap " << gap_m << ", " << substeps
                                            << " substeps of " << rate << " Hz");
          const std::vector<double> speeds = speeds_of_cradle(row, gap_m, 1.0, rate, substeps);
          EXPECT_GE(speeds.back(), 0.98 * kSpeed_m_s);
          double energy = 0.0;
          for (const double speed : speeds) energy += speed * speed;
          EXPECT_NEAR(energy / (kSpeed_m_s * kSpeed_m_s), 1.0, 0.01);
        }
      }
    }
  }
}

// In a row with restitution e each ball passes on (1 + e) / 2 of its speed and keeps the rest. With a row of
// two, the ball in the middle keeps (1 + e)(1 - e) / 4 of it and is not caught up with if e is above 1/3.
TEST(Impacts, TwoTouchingBallsShareTheSpeedByRestitution) {
  for (const double rate : kRates_hz) {
    for (const double e : {0.5, 0.8}) {
      const std::vector<double> speeds = speeds_of_cradle(2, 0.0, e, rate, 4);
      const double passed = 0.5 * (1 + e), kept = 0.5 * (1 - e);
      EXPECT_NEAR(speeds[2], kSpeed_m_s * passed * passed, 0.01 * kSpeed_m_s) << e;
      EXPECT_NEAR(speeds[0] + speeds[1], kSpeed_m_s * (kept + passed * kept), 0.01 * kSpeed_m_s) << e;
    }
  }
}

// A ball between two touching ones: by symmetry they leave at 30 degrees; energy and momentum give a fifth of
// the speed backwards and 2 sqrt(3) / 5 of it for each.
TEST(Impacts, BreakOfThreeIsSymmetric) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4, Vector3d::Zero());
    ASSERT_TRUE(world.add_ball(smooth_ball(2, {0, 0, kRadius_m}, 1.0)));
    ASSERT_TRUE(world.add_ball(smooth_ball(3, {0, 0, -kRadius_m}, 1.0)));
    BallDescription cue = smooth_ball(1, {-0.5, 0, 0}, 1.0);
    cue.velocity_m_s = {kSpeed_m_s, 0, 0};
    ASSERT_TRUE(world.add_ball(cue));
    run_seconds(world, 0.5);
    const double speed = 2.0 * std::sqrt(3.0) / 5.0 * kSpeed_m_s;
    EXPECT_NEAR(body_state(world, 1).velocity_m_s.x(), -kSpeed_m_s / 5.0, 0.01 * kSpeed_m_s);
    for (const uint32_t id : {2u, 3u}) {
      const Vector3d velocity = body_state(world, id).velocity_m_s;
      EXPECT_NEAR(velocity.x(), speed * std::cos(radians(30)), 0.01 * speed);
      EXPECT_NEAR(std::abs(velocity.z()), speed * std::sin(radians(30)), 0.01 * speed);
    }
  }
}

// A frictionless box on an edge: each impact conserves energy at e = 1 although four points take part.
TEST(Impacts, TumblingBoxKeepsItsEnergy) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.0, 1.0));
    RigidBodyDescription box = box_body(1, {0.2, 0.1, 0.3}, 1.0);
    box.material.friction = 0.0;
    box.material.restitution = 1.0;
    box.world_from_object.position_m = {0, 1.0, 0};
    box.world_from_object.orientation = Eigen::AngleAxisd(0.6, Vector3d(1, 2, 3).normalized());
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 4.0);
    const BodyState state = body_state(world, 1);
    const Eigen::Matrix3d turn = state.world_from_body.orientation.toRotationMatrix();
    const Vector3d spin = turn.transpose() * state.angular_velocity_rad_s;
    const Vector3d inertia =
        Vector3d(0.1 * 0.1 + 0.3 * 0.3, 0.2 * 0.2 + 0.3 * 0.3, 0.2 * 0.2 + 0.1 * 0.1) / 12.0;
    const double energy = 0.5 * state.velocity_m_s.squaredNorm() +
                          0.5 * spin.dot(inertia.cwiseProduct(spin)) +
                          kGravity * state.world_from_body.position_m.y();
    EXPECT_NEAR(energy / kGravity, 1.0, 0.01);
  }
}

}  // namespace
}  // namespace livegs

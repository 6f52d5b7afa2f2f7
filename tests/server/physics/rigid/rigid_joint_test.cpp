// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "scenes/rigid_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

double agm(double a, double b) {
  while (std::abs(a - b) > 1e-15 * a) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return a;
}

// Period of a physical pendulum of `amplitude`: 2 pi sqrt(I / (m g l)) / agm(1, cos(amplitude / 2)), I about
// the pivot.
double pendulum_period_s(double unit_inertia_about_pivot, double length_m, double amplitude) {
  const double small = 2.0 * std::numbers::pi * std::sqrt(unit_inertia_about_pivot / (kGravity * length_m));
  return small / agm(1.0, std::cos(0.5 * amplitude));
}

// The pose rotated by `angle` about z through the origin, with the object's `pivot_m` at the origin.
Pose turned_about_pivot(const Vector3d& pivot_m, double angle) {
  Pose pose;
  pose.orientation = Quaterniond(AngleAxisd(angle, Vector3d::UnitZ()));
  pose.position_m = -(pose.orientation * pivot_m);
  return pose;
}

double angle_about_z(const BodyState& state) {
  const Quaterniond& q = state.world_from_body.orientation;
  return 2.0 * std::atan2(q.z(), q.w());
}

double total_j(const World& world) {
  const BodyEnergy energy = world.energy();
  return energy.kinetic_j + energy.gravity_j;
}

struct Swing {
  double period_s = 0, lost = 0, largest_error_m = 0, largest_error_rad = 0, largest_off_plane_m = 0;
};

// Runs ten seconds from rest at `amplitude`. Body 1 swings about z through the origin.
Swing swing(World& world, double length_m, double amplitude) {
  Swing result;
  const double before = total_j(world);
  std::vector<double> crossings;
  double last = amplitude;
  const double tick_s = 1.0 / world.settings().rate_hz;
  for (int i = 1; i <= std::lround(10.0 * world.settings().rate_hz); ++i) {
    world.step();
    const BodyState state = body_state(world, 1);
    const double angle = angle_about_z(state);
    // At its fastest point the pendulum's angle is linear in time up to third order.
    if (last < 0.0 && angle >= 0.0) crossings.push_back((i - 1 - last / (angle - last)) * tick_s);
    last = angle;
    for (const JointState& joint : world.joints()) {
      result.largest_error_m = std::max(result.largest_error_m, joint.error_m);
      result.largest_error_rad = std::max(result.largest_error_rad, joint.error_rad);
    }
    result.largest_off_plane_m =
        std::max(result.largest_off_plane_m, std::abs(state.world_from_body.position_m.z()));
  }
  result.period_s = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  const double swing_j = body_state(world, 1).mass_kg * kGravity * length_m * (1.0 - std::cos(amplitude));
  result.lost = (before - total_j(world)) / swing_j;
  return result;
}

// Second order in the substep: the period is short by (h omega)²/24, 7e-6 at 240 Hz; the test allows ten
// times that. The bar is 1e-3, and 1 % of energy. Newton iterations close the joint to rounding.
void expect_swings(const Swing& result, double period_s) {
  EXPECT_NEAR(result.period_s / period_s, 1.0, 1e-4);
  EXPECT_LT(std::abs(result.lost), 2e-4);
  EXPECT_LT(result.largest_error_m, 1e-9);
  EXPECT_LT(result.largest_error_rad, 1e-9);
  EXPECT_LT(result.largest_off_plane_m, 1e-9);
}

TEST(RigidJoint, BallJointPendulumKeepsPeriodAndEnergy) {
  for (const double rate : kRates_hz) {
    for (const double degrees : {5.0, 60.0}) {
      World world = world_at(rate, 4);
      auto bob = body_of(1, sphere_mesh(0.05, 3), 1.0);
      const Vector3d pivot(0, 1, 0);
      bob.world_from_object = turned_about_pivot(pivot, radians(degrees));
      ASSERT_TRUE(world.add_rigid(bob));
      ASSERT_TRUE(world.add_ball_joint({1, {}, pivot}));
      expect_swings(swing(world, 1.0, radians(degrees)),
                    pendulum_period_s(bob.properties.inertia_m2(2, 2) + 1.0, 1.0, radians(degrees)));
    }
  }
}

TEST(RigidJoint, HingePendulumKeepsPeriodAndEnergy) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4);
    auto bob = box_body(1, {0.1, 0.6, 0.3}, 2.0);
    const Vector3d pivot(0, 0.3, 0);
    bob.world_from_object = turned_about_pivot(pivot, radians(40));
    ASSERT_TRUE(world.add_rigid(bob));
    ASSERT_TRUE(world.add_hinge_joint({1, {}, pivot, {0, 0, 2}}));
    expect_swings(swing(world, 0.3, radians(40)),
                  pendulum_period_s(bob.properties.inertia_m2(2, 2) + 0.09, 0.3, radians(40)));
  }
}

// Doors have two hinges; the rows of the second are redundant.
TEST(RigidJoint, DoorPushedAtAnAngleSwingsAboutItsAxis) {
  for (const double rate : kRates_hz) {
    for (const int hinges : {1, 2}) {
      World world = world_at(rate, 4);
      auto door = box_body(1, {0.8, 2.0, 0.04}, 20.0);
      ASSERT_TRUE(world.add_rigid(door));
      ASSERT_TRUE(world.add_hinge_joint({1, {}, {-0.4, 0.8, 0}, Vector3d::UnitY()}));
      if (hinges == 2) {
        ASSERT_TRUE(world.add_hinge_joint({1, {}, {-0.4, -0.8, 0}, Vector3d::UnitY()}));
      }
      // Force components at the handle: out of the door's plane, along it and up. Only the first turns the
      // door.
      world.set_force(1, 1, {{0.35, -0.3, 0}, {30, 40, -5}});
      const double torque = 5.0 * 0.75;
      const double unit_inertia = door.properties.inertia_m2(1, 1) + 0.16;
      for (int i = 0; i < std::lround(0.25 * rate); ++i) world.step();
      // Early on the lever arm of the force is nearly the door's width: the error grows with the square of
      // the angle, as does the turning part of the force along the door. At 0.25 s the angle is 0.03 rad.
      const BodyState early = body_state(world, 1);
      const double spin = torque / (20.0 * unit_inertia) * std::lround(0.25 * rate) / rate;
      EXPECT_NEAR(early.angular_velocity_rad_s.y() / spin, 1.0, 0.1);
      double error_m = 0.0, error_rad = 0.0;
      for (int i = 0; i < std::lround(10.0 * rate); ++i) {
        world.step();
        for (const JointState& joint : world.joints()) {
          error_m = std::max(error_m, joint.error_m);
          error_rad = std::max(error_rad, joint.error_rad);
        }
      }
      EXPECT_LT(error_m, 1e-6);
      EXPECT_LT(error_rad, 1e-6);
      EXPECT_LT(
          (body_state(world, 1).world_from_body.orientation * Vector3d::UnitY() - Vector3d::UnitY()).norm(),
          1e-6);
    }
  }
}

// A chain released from level: links of 0.1 m and 0.1 kg along x from the origin, then a box of `ratio` times
// the link mass.
World chain(double rate, double ratio, double angle = 0.0, int links = 20) {
  World world = world_at(rate, 4);
  const Quaterniond turn(AngleAxisd(-angle, Vector3d::UnitZ()));
  for (int i = 1; i <= links; ++i) {
    auto link = box_body(static_cast<uint32_t>(i), {0.1, 0.02, 0.02}, 0.1);
    link.world_from_object.position_m = turn * Vector3d(0.1 * i - 0.05, 0, 0);
    link.world_from_object.orientation = turn;
    EXPECT_TRUE(world.add_rigid(link));
    std::optional<uint32_t> above;
    if (i > 1) above = static_cast<uint32_t>(i - 1);
    EXPECT_TRUE(world.add_ball_joint({static_cast<uint32_t>(i), above, Vector3d(-0.05, 0, 0)}));
  }
  const auto last = static_cast<uint32_t>(links + 1);
  auto weight = box_body(last, {0.1, 0.1, 0.1}, 0.1 * ratio);
  weight.world_from_object.position_m = turn * Vector3d(0.1 * links + 0.05, 0, 0);
  weight.world_from_object.orientation = turn;
  EXPECT_TRUE(world.add_rigid(weight));
  EXPECT_TRUE(world.add_ball_joint({last, last - 1, Vector3d(-0.05, 0, 0)}));
  return world;
}

struct ChainRun {
  // largest values; energy relative to the weight's fall through the chain's length
  double stretch = 0, gained = 0;
  bool finite = true;
};

ChainRun run_chain(World& world, double ratio, double seconds) {
  ChainRun run;
  const double before = total_j(world), fall_j = 0.1 * ratio * kGravity * 2.0;
  for (int i = 0; i < std::lround(seconds * world.settings().rate_hz); ++i) {
    world.step();
    double length_m = 0.0;
    const auto joints = world.joints();
    for (size_t j = 1; j < joints.size(); ++j) length_m += (joints[j].point_m - joints[j - 1].point_m).norm();
    run.stretch = std::max(run.stretch, std::abs(length_m / 2.0 - 1.0));
    run.gained = std::max(run.gained, (total_j(world) - before) / fall_j);
    run.finite = run.finite && std::isfinite(total_j(world)) && std::isfinite(length_m);
  }
  return run;
}

// The rows of a chain are solved together, so the mass ratio does not matter. The bars are 2 % at 1:100, 5 %
// at 1:1000, and finite at 1:50000.
TEST(RigidJoint, HeavyEndedChainDoesNotStretch) {
  for (const double rate : kRates_hz) {
    for (const double ratio : {1.0, 100.0, 1000.0, 50000.0}) {
      World world = chain(rate, ratio, radians(60));
      const ChainRun run = run_chain(world, ratio, 1.0);
      EXPECT_TRUE(run.finite);
      EXPECT_LT(run.stretch, 1e-6) << "1:" << ratio;
      EXPECT_LT(run.gained, 1e-4) << "1:" << ratio;
    }
  }
}

// Released from level, the chain is at rest while its weight falls; then it snaps tight and whips. The motion
// has no reference. It must be bounded, end, and gain no energy.
TEST(RigidJoint, ChainThatSnapsTightStaysJoined) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    for (const double ratio : {1.0, 100.0, 1000.0, 50000.0}) {
      World world = chain(rate, ratio, 0.0);
      const ChainRun run = run_chain(world, ratio, 1.5);
      EXPECT_TRUE(run.finite);
      if (ratio <= 1000.0) EXPECT_LT(run.stretch, 0.02) << "1:" << ratio;
      EXPECT_LT(run.gained, 0.05) << "1:" << ratio;
    }
  }
}

struct Top {
  double precession_rad_s = 0;
  double nutation_m[2] = {0, 0};  // height of the centre, peak to peak, in the first and the second half
};

// Spins a level disc of 1 kg on a lever of 0.1 m for ten seconds. Its y axis is rotated to x.
Top spin_top(double rate, double spin, double precession, const RigidBodyDescription& shape, double lever_m) {
  World world = world_at(rate, 4);
  RigidBodyDescription disc = shape;
  disc.world_from_object.orientation = Quaterniond(AngleAxisd(-0.5 * std::numbers::pi, Vector3d::UnitZ()));
  disc.world_from_object.position_m = {lever_m, 0, 0};
  disc.angular_velocity_rad_s = {spin, precession, 0};
  disc.velocity_m_s = disc.angular_velocity_rad_s.cross(Vector3d(lever_m, 0, 0));
  EXPECT_TRUE(world.add_rigid(disc));
  EXPECT_TRUE(world.add_ball_joint({1, {}, Vector3d(0, -lever_m, 0)}));
  Top top;
  double angle = 0.0, last = 0.0, low[2] = {1, 1}, high[2] = {-1, -1};
  const int ticks = static_cast<int>(10.0 * rate);
  for (int i = 0; i < ticks; ++i) {
    world.step();
    const Vector3d at = body_state(world, 1).world_from_body.position_m;
    const double now = std::atan2(-at.z(), at.x());
    angle += std::remainder(now - last, 2.0 * std::numbers::pi);
    last = now;
    const int half = 2 * i / ticks;
    low[half] = std::min(low[half], at.y());
    high[half] = std::max(high[half], at.y());
  }
  top.precession_rad_s = angle / 10.0;
  for (int half : {0, 1}) top.nutation_m[half] = high[half] - low[half];
  return top;
}

TEST(RigidJoint, TopPrecesses) {
  const auto disc = body_of(1, cylinder_mesh(0.1, 0.01, 128), 1.0);
  const double lever_m = 0.1, spin = 100.0;
  const double precession = kGravity * lever_m / (disc.properties.inertia_m2(1, 1) * spin);  // m g l / (I3 w)
  for (const double rate : kRates_hz) {
    // A level top started at its precession rate precesses steadily.
    const Top steady = spin_top(rate, spin, precession, disc, lever_m);
    EXPECT_NEAR(steady.precession_rad_s / precession, 1.0, 0.01);
    EXPECT_LT(steady.nutation_m[0], 5e-4);
    EXPECT_LE(steady.nutation_m[1], 1.02 * steady.nutation_m[0]);
    // Released, the top nutates by an angle of 2 m g l I1 / (I3 w)², I1 about the pivot. With nine samples
    // per period the peaks are within 5 %.
    const Top dropped = spin_top(rate, spin, 0.0, disc, lever_m);
    const double momentum = disc.properties.inertia_m2(1, 1) * spin;
    const double dip_m = lever_m * 2.0 * kGravity * lever_m *
                         (disc.properties.inertia_m2(0, 0) + lever_m * lever_m) / (momentum * momentum);
    EXPECT_NEAR(dropped.precession_rad_s / precession, 1.0, 0.01);
    EXPECT_NEAR(dropped.nutation_m[0] / dip_m, 1.0, 0.05);
    EXPECT_LE(dropped.nutation_m[1], 1.02 * dropped.nutation_m[0]);
  }
}

TEST(RigidJoint, JoinedFreeBodiesConserveMomentum) {
  for (const double rate : kRates_hz) {
    for (const bool hinge : {false, true}) {
      World world = world_at(rate, 4, Vector3d::Zero());
      auto one = box_body(1, {0.3, 0.1, 0.05}, 1.0);
      one.velocity_m_s = {1, 2, -1};
      one.angular_velocity_rad_s = {3, -4, 5};
      auto two = box_body(2, {0.1, 0.2, 0.1}, 20.0);
      two.world_from_object.position_m = {0.2, 0.1, 0};
      two.world_from_object.orientation = rotation_about(3);
      ASSERT_TRUE(world.add_rigid(one));
      ASSERT_TRUE(world.add_rigid(two));
      if (hinge) {
        ASSERT_TRUE(world.add_hinge_joint({1, 2, Vector3d(0.15, 0.05, 0), Vector3d(1, 1, 0)}));
      } else {
        ASSERT_TRUE(world.add_ball_joint({1, 2, Vector3d(0.15, 0.05, 0)}));
      }
      const BodyEnergy before = world.energy();
      world.step();
      const double joined_j = world.energy().kinetic_j;  // the relative motion at the joint is dissipated
      for (int i = 0; i < std::lround(10.0 * rate); ++i) {
        world.step();
        ASSERT_LT(world.joints()[0].error_m, 1e-6);
        ASSERT_LT(world.joints()[0].error_rad, 1e-6);
      }
      // Momenta of about 2 kg m/s and 2 kg m²/s over 3600 substeps: rounding.
      const BodyEnergy after = world.energy();
      EXPECT_LT((after.linear_momentum - before.linear_momentum).norm(), 1e-12);
      EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-12);
      EXPECT_NEAR(after.kinetic_j / joined_j, 1.0, 3e-3);  // second order; it oscillates
    }
  }
}

TEST(RigidJoint, JoinedBodiesSleepTogetherWithoutContact) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4);
    // A ball inside the box it is joined to. Without the joint they would be pushed apart.
    ASSERT_TRUE(world.add_rigid(box_body(1, {0.2, 0.2, 0.2}, 1.0)));
    ASSERT_TRUE(world.add_ball(ball(2, {0, -0.1, 0})));
    ASSERT_TRUE(world.add_ball_joint({1, {}, Vector3d(0, 0.1, 0)}));
    ASSERT_TRUE(world.add_ball_joint({2, 1, Vector3d(0, 0, 0)}));
    run_seconds(world, 2.0);
    EXPECT_LT(body_state(world, 2).world_from_body.position_m.norm(), 0.1 + 1e-6);
    EXPECT_TRUE(body_state(world, 1).asleep);
    EXPECT_TRUE(body_state(world, 2).asleep);
    world.set_force(1, 2, {Vector3d::Zero(), {0, 0, 3}}, 1.0 / world.settings().rate_hz);
    world.step();
    EXPECT_FALSE(body_state(world, 1).asleep);
    EXPECT_FALSE(body_state(world, 2).asleep);
    // Removing a body releases the body joined to it.
    world.remove(1);
    EXPECT_TRUE(world.joints().empty());
    run_seconds(world, 1.0);
    EXPECT_LT(body_state(world, 2).world_from_body.position_m.y(), -3.0);
  }
}

TEST(RigidJoint, RejectsInvalidJoints) {
  World world = world_at(60, 4);
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.2, 0.2, 0.2}, 1.0)));
  ASSERT_TRUE(world.add_static(2, Pose{}));
  const std::string unknown = "joint: object 7 is unknown; give the id of an object in the world";
  EXPECT_EQ(world.add_ball_joint({7, {}, Vector3d::Zero()}).error().message, unknown);
  EXPECT_EQ(world.add_ball_joint({1, 7, Vector3d::Zero()}).error().message, unknown);
  EXPECT_EQ(world.add_ball_joint({1, 1, Vector3d::Zero()}).error().message,
            "joint: object 1 cannot be joined to itself; name another object");
  EXPECT_EQ(world.add_ball_joint({2, 1, Vector3d::Zero()}).error().message,
            "joint: object 2 is static; name the moving object first");
  EXPECT_EQ(world.add_ball_joint({1, {}, Vector3d(NAN, 0, 0)}).error().message,
            "joint of object 1: point_m is not finite");
  EXPECT_EQ(world.add_hinge_joint({1, {}, Vector3d::Zero(), Vector3d::Zero()}).error().message,
            "joint of object 1: axis is zero or not finite");
  EXPECT_TRUE(world.add_ball_joint({1, 2, Vector3d::Zero()}));  // to a static body, that is, the world
}

}  // namespace
}  // namespace livegs

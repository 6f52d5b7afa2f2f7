// SPDX-License-Identifier: Apache-2.0
// Rigid bodies whose parts have different friction.
#include "physics/surface_friction.h"

#include <gtest/gtest.h>

#include <limits>

#include "scenes/rigid_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// The half of a body with x > 0.
FrictionBox right_half(double factor) {
  return {{Vector3d(0, -kInfinite, -kInfinite), Vector3d::Constant(kInfinite)}, factor};
}

TEST(SurfaceFriction, LastBoxThatContainsThePointApplies) {
  SurfaceFriction friction{.own = 0.5, .boxes = nullptr};
  EXPECT_EQ(friction.at({1, 0, 0}, 1), 0.5);
  friction.boxes = std::make_shared<const std::vector<FrictionBox>>(
      std::vector<FrictionBox>{right_half(0.2),
                               {{Vector3d(0.5, -1, -1), Vector3d(0.6, 1, 1)}, 3},
                               {{Vector3d(3, 3, 3), Vector3d(4, 4, 4)}, 90}});
  EXPECT_EQ(friction.at({-0.1, 0, 0}, 1), 0.5);
  EXPECT_DOUBLE_EQ(friction.at({0.1, 0, 0}, 1), 0.1);
  EXPECT_DOUBLE_EQ(friction.at({0.55, 0, 0}, 1), 1.5);
  EXPECT_DOUBLE_EQ(friction.at({0.605, 0, 0}, 1), 1.5);  // a contact point slightly outside
  EXPECT_DOUBLE_EQ(friction.at({0.62, 0, 0}, 1), 0.1);
  EXPECT_EQ(friction.at({3, 3, 3}, 1), kMaxFriction);
}

// A box of length L and height h slides at x > 0 first; each half has its own friction with the floor. With
// the loads N at its ends, Coulomb's law and the balance of moments give F = mg m / (1 - (f - b) h / 2L),
// with m the mean of the frictions of the front f and of the back b.
double sliding_deceleration(double front, double back, double length_m, double height_m) {
  return kGravity * 0.5 * (front + back) / (1.0 - 0.5 * (front - back) * height_m / length_m);
}

TEST(SurfaceFriction, BoxOfTwoHalvesIsSlowedByBoth) {
  constexpr double kLength_m = 0.4, kHeight_m = 0.1, kFloor = 0.5, kOwn = 0.5;
  for (const double rate : kRates_hz) {
    for (const double factor : {0.0, 0.25, 2.0}) {
      for (const double direction : {1.0, -1.0}) {
        SCOPED_TRACE(testing::Message() << rate << " Hz, factor " << factor << ", direction " << direction);
        World world = world_at(rate, 4);
        world.add_collider(floor_plane(kFloor));
        auto box = box_body(1, {kLength_m, kHeight_m, 0.2}, 1.0);
        box.material.friction = kOwn;
        box.material.restitution = 0;
        box.friction_boxes = {right_half(factor)};
        box.world_from_object.position_m = {0, 0.5 * kHeight_m, 0};
        box.velocity_m_s = {3 * direction, 0, 0};
        ASSERT_TRUE(world.add_rigid(box));
        run_seconds(world, 0.1);
        const double before_m_s = body_state(world, 1).velocity_m_s.x();
        run_seconds(world, 0.3);
        const double right = std::sqrt(kFloor * factor * kOwn), left = std::sqrt(kFloor * kOwn);
        const double expected = direction > 0 ? sliding_deceleration(right, left, kLength_m, kHeight_m)
                                              : sliding_deceleration(left, right, kLength_m, kHeight_m);
        const double slowed = direction * (before_m_s - body_state(world, 1).velocity_m_s.x()) / 0.3;
        EXPECT_NEAR(slowed / expected, 1.0, 0.01);
      }
    }
  }
}

// Mean angular acceleration between two times of a slab that slides forwards (-z) on two halves side by side,
// positive to the left. Its weight is shared by its four corners, at half its width w from the middle, and
// friction along z does not move the load sideways. The halves pull with l m g / 2 and r m g / 2, a couple of
// (l - r) m g / 2 * w / 2. It turns the slab, whose corners, half its depth d from the middle, then also slip
// sideways by spin * d / 2, which brakes the spin with (l + r) / 2 m g / speed (d / 2)² times the spin.
double turning_acceleration(double left, double right, double width_m, double depth_m, double speed_m_s,
                            double from_s, double to_s) {
  const double inertia_m2 = (width_m * width_m + depth_m * depth_m) / 12;  // for each kilogram
  const double start_rad_s2 = 0.25 * (left - right) * kGravity * width_m / inertia_m2;
  const double brake_per_s = 0.125 * (left + right) * kGravity * depth_m * depth_m / (speed_m_s * inertia_m2);
  return start_rad_s2 * (std::exp(-brake_per_s * from_s) - std::exp(-brake_per_s * to_s)) /
         (brake_per_s * (to_s - from_s));
}

TEST(SurfaceFriction, SlabTurnsToItsRougherSide) {
  constexpr double kFloor = 0.5, kOwn = 0.5, kSpeed_m_s = 4;
  constexpr int kTicks = 4;
  for (const double rate : kRates_hz) {
    for (const auto& [width_m, depth_m] : {std::pair(0.3, 0.3), std::pair(0.4, 0.1)}) {
      for (const double factor : {0.0, 0.25, 1.0, 2.0}) {
        SCOPED_TRACE(testing::Message() << rate << " Hz, " << width_m << " m, factor " << factor);
        World world = world_at(rate, 4);
        world.add_collider(floor_plane(kFloor));
        auto slab = box_body(1, {width_m, 0.02, depth_m}, 1.0);
        slab.material.friction = kOwn;
        slab.material.restitution = 0;
        slab.friction_boxes = {right_half(factor)};
        slab.world_from_object.position_m = {0, 0.01, 0};
        slab.velocity_m_s = {0, 0, -kSpeed_m_s};
        ASSERT_TRUE(world.add_rigid(slab));
        world.step();  // lands
        const double before_rad_s = body_state(world, 1).angular_velocity_rad_s.y();
        for (int tick = 0; tick < kTicks; ++tick) world.step();
        const double turning =
            (body_state(world, 1).angular_velocity_rad_s.y() - before_rad_s) * rate / kTicks;
        if (factor == 1) {
          EXPECT_NEAR(turning, 0, 0.03) << "equal halves";
          continue;
        }
        const double expected =
            turning_acceleration(std::sqrt(kFloor * kOwn), std::sqrt(kFloor * factor * kOwn), width_m,
                                 depth_m, kSpeed_m_s, 1 / rate, (1 + kTicks) / rate);
        std::printf("%.3g m, factor %.2f: %.2f of %.2f rad/s2\n", width_m, factor, turning, expected);
        EXPECT_NEAR(turning / expected, 1, 0.02);
      }
    }
  }
}

// The friction between two bodies is that of the parts that touch: cubes slide over the two halves of a
// board.
TEST(SurfaceFriction, ThePartThatTouchesCounts) {
  World world = world_at(90, 4);
  world.add_collider(floor_plane(1));
  auto board = box_body(1, {1, 0.1, 4}, 1000);
  board.material.friction = 1;
  board.friction_boxes = {right_half(0.01)};
  board.world_from_object.position_m = {0, 0.05, 0};
  ASSERT_TRUE(world.add_rigid(board));
  for (const auto& [id, x_m] : {std::pair(2u, -0.25), std::pair(3u, 0.25)}) {
    auto cube = box_body(id, {0.1, 0.05, 0.1}, 0.2);
    cube.material.friction = 0.25;
    cube.world_from_object.position_m = {x_m, 0.125, -1};
    cube.velocity_m_s = {0, 0, 2};
    ASSERT_TRUE(world.add_rigid(cube));
  }
  run_seconds(world, 0.2);
  EXPECT_NEAR((2 - body_state(world, 2).velocity_m_s.z()) / (0.2 * kGravity * std::sqrt(0.25 * 1)), 1, 0.01);
  EXPECT_NEAR((2 - body_state(world, 3).velocity_m_s.z()) / (0.2 * kGravity * std::sqrt(0.25 * 0.01)), 1,
              0.01);
}

// Way and angle of a box that slides and spins until it rests: each of its four corners carries a quarter of
// the weight, with Coulomb's friction against its own slip. Integrated in small steps.
struct Stopped {
  double way_m, turned_rad;
};
Stopped slides_and_spins(double speed_m_s, double spin_rad_s, double half_m, double friction) {
  const double inertia_m2 = 2.0 / 3.0 * half_m * half_m, step_s = 1e-5;
  Eigen::Vector2d speed(speed_m_s, 0);
  Stopped stopped{0, 0};
  while (speed.norm() > 1e-3 || std::abs(spin_rad_s) * half_m > 1e-3) {
    Eigen::Vector2d force = Eigen::Vector2d::Zero();
    double couple = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector2d arm =
          Eigen::Rotation2Dd(stopped.turned_rad + corner * M_PI / 2) * Eigen::Vector2d(half_m, half_m);
      const Eigen::Vector2d slip = speed + spin_rad_s * Eigen::Vector2d(-arm.y(), arm.x());
      const Eigen::Vector2d pull = -0.25 * friction * kGravity * slip / std::max(slip.norm(), 1e-6);
      force += pull;
      couple += arm.x() * pull.y() - arm.y() * pull.x();
    }
    speed += step_s * force;
    spin_rad_s += step_s * couple / inertia_m2;
    stopped.way_m += step_s * speed.x();
    stopped.turned_rad += step_s * spin_rad_s;
  }
  return stopped;
}

// Sliding takes friction from spinning and the reverse. Without spin the way is exact.
TEST(SurfaceFriction, SlidingAndSpinningBoxStops) {
  constexpr double kHalf_m = 0.1, kFriction = 0.4;
  for (const double rate : kRates_hz) {
    for (const auto& [speed_m_s, spin_rad_s] :
         {std::pair(1.5, 0.0), std::pair(1.5, 10.0), std::pair(0.7, 15.0)}) {
      SCOPED_TRACE(testing::Message() << rate << " Hz, " << speed_m_s << " m/s, " << spin_rad_s << " rad/s");
      World world = world_at(rate, 4);
      world.add_collider(floor_plane(kFriction));
      auto box = box_body(1, {2 * kHalf_m, 0.06, 2 * kHalf_m}, 1.0);
      box.material.friction = kFriction;
      box.world_from_object.position_m = {0, 0.03, 0};
      box.velocity_m_s = {speed_m_s, 0, 0};
      box.angular_velocity_rad_s = {0, spin_rad_s, 0};
      ASSERT_TRUE(world.add_rigid(box));
      double turned_rad = 0.5 * spin_rad_s / rate;  // trapezoidal rule; the box ends at rest
      for (int tick = 0; tick < 2 * rate; ++tick) {
        world.step();
        turned_rad += body_state(world, 1).angular_velocity_rad_s.y() / rate;
      }
      const Stopped expected = slides_and_spins(speed_m_s, spin_rad_s, kHalf_m, kFriction);
      const double way_m = body_state(world, 1).world_from_body.position_m.x();
      std::printf("way %.3f of %.3f m, turned %.3f of %.3f rad\n", way_m, expected.way_m, turned_rad,
                  expected.turned_rad);
      EXPECT_NEAR(way_m / expected.way_m, 1, 0.01);
      if (spin_rad_s > 0) EXPECT_NEAR(turned_rad / expected.turned_rad, 1, 0.01);
    }
  }
}

TEST(SurfaceFriction, EditOfTheObjectScalesItsParts) {
  World world = world_at(90, 4);
  world.add_collider(floor_plane(0.5));
  auto box = box_body(1, {0.2, 0.05, 0.2}, 1.0);
  box.material.friction = 0.5;
  box.friction_boxes = {right_half(0.5),
                        {{-Vector3d::Constant(kInfinite), Vector3d(0, kInfinite, kInfinite)}, 0.5}};
  box.world_from_object.position_m = {0, 0.025, 0};
  box.velocity_m_s = {4, 0, 0};
  ASSERT_TRUE(world.add_rigid(box));
  const auto slowed = [&] {
    const double before_m_s = body_state(world, 1).velocity_m_s.x();
    run_seconds(world, 0.2);
    return (before_m_s - body_state(world, 1).velocity_m_s.x()) / 0.2;
  };
  EXPECT_NEAR(slowed() / (std::sqrt(0.5 * 0.25) * kGravity), 1, 0.01);
  Material edited = *world.material(1);
  edited.friction = 1;
  ASSERT_TRUE(world.set_material(1, edited));
  EXPECT_NEAR(slowed() / (std::sqrt(0.5 * 0.5) * kGravity), 1, 0.01);
}

TEST(SurfaceFriction, ImpossibleFactorIsRefused) {
  for (const double factor : {-1.0, 1e9, std::nan("")}) {
    World world = world_at(90, 4);
    auto box = box_body(1, {0.2, 0.05, 0.2}, 1.0);
    box.friction_boxes = {right_half(factor)};
    const auto added = world.add_rigid(box);
    ASSERT_FALSE(added);
    EXPECT_NE(added.error().message.find("friction_boxes.factor"), std::string::npos)
        << added.error().message;
  }
}

}  // namespace
}  // namespace livegs

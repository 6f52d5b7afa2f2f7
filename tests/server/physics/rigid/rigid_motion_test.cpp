// SPDX-License-Identifier: Apache-2.0
#include "physics/motion/free_rotation.h"

#include <gtest/gtest.h>

#include <sstream>

#include "scenes/rigid_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

// Allowed relative change of the kinetic energy of a spin.
constexpr double kSpinEnergy = 1e-3;

TEST(RigidMotion, ProjectileFollowsTheParabola) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4);
    auto box = box_body(1, {0.1, 0.1, 0.1}, 1.0);
    box.velocity_m_s = {10, 10, 0};
    ASSERT_TRUE(world.add_rigid(box));
    run_seconds(world, 2.0);
    const BodyState state = body_state(world, 1);
    // The scheme is exact for a constant acceleration: only the rounding of 720 sums of about 10 m is left.
    EXPECT_NEAR(state.world_from_body.position_m.x(), 20.0, 1e-10);
    EXPECT_NEAR(state.world_from_body.position_m.y(), 20.0 - 0.5 * kGravity * 4.0, 1e-10);
    EXPECT_NEAR(state.velocity_m_s.y(), 10.0 - kGravity * 2.0, 1e-10);
  }
}

TEST(RigidMotion, ExponentialMapIsTheRotationByAxisAndAngle) {
  const Vector3d axis = Vector3d(1, 2, -2).normalized();
  for (const double angle : {0.0, 1e-9, 1e-4, 0.3, 3.0}) {
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(angle, axis));
    EXPECT_LT(rotation_exp(angle * axis).angularDistance(expected), 1e-7) << angle;  // acos of 1 - eps
    EXPECT_NEAR(rotation_exp(angle * axis).norm(), 1.0, 1e-15);
  }
}

TEST(RigidMotion, FreeSpinIsConstant) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4, Vector3d::Zero());
    auto body = body_of(1, sphere_mesh(0.1, 3), 1.0);
    body.angular_velocity_rad_s = {0, 50, 0};
    ASSERT_TRUE(world.add_rigid(body));
    run_seconds(world, 10.0);
    // Icosahedral symmetry gives an isotropic inertia, so omega is constant; 1e-4 is the catalogue's bar
    // (scene 10).
    EXPECT_NEAR((body_state(world, 1).angular_velocity_rad_s - Vector3d(0, 50, 0)).norm() / 50.0, 0.0, 1e-4);
  }
}

// Needles, discs and plates whose moments of inertia differ up to five-thousandfold. They spin about several
// axes at the rates that fracture or a fall on an edge may cause. Kinetic energy is half of L times omega,
// and L is conserved by construction.
TEST(RigidMotion, FastSpinningThinBodiesKeepTheirEnergy) {
  const Vector3d sizes[] = {
      {0.004, 0.3, 0.004}, {0.001, 0.03, 0.001}, {0.3, 0.001, 0.3}, {0.3, 0.002, 0.1}, {0.3, 0.2, 0.05}};
  const Vector3d spins[] = {{5, 400, 0}, {20, 200, 200}, {300, 10, 1}, {50, 50, 50}, {0.01, 300, 0.02}};
  for (const double rate : kRates_hz) {
    for (const Vector3d& size : sizes) {
      for (const Vector3d& spin : spins) {
        std::ostringstream what;
        what << rate << " Hz, " << size.transpose() << " m, " << spin.transpose() << " rad/s";
        SCOPED_TRACE(what.str());
        World world = world_at(rate, 4, Vector3d::Zero());
        auto box = box_body(1, size, 0.1);
        box.angular_velocity_rad_s = spin;
        ASSERT_TRUE(world.add_rigid(box));
        const double before = world.energy().kinetic_j;
        double least = 1.0, most = 1.0;
        for (int i = 0; i < 2 * rate; ++i) {
          world.step();
          least = std::min(least, world.energy().kinetic_j / before);
          most = std::max(most, world.energy().kinetic_j / before);
        }
        // The energy of a rigid body is constant; the error of the splitting does not grow.
        EXPECT_GT(least, 1.0 - kSpinEnergy);
        EXPECT_LT(most, 1.0 + kSpinEnergy);
      }
    }
  }
}

// A rod is a symmetric top: its axis precesses about the angular momentum at |L| / I, in closed form.
TEST(RigidMotion, RodPrecessesInClosedForm) {
  World world = world_at(90, 4, Vector3d::Zero());
  auto rod = box_body(1, {0.004, 0.3, 0.004}, 0.1);
  rod.angular_velocity_rad_s = {5, 400, 0};
  ASSERT_TRUE(world.add_rigid(rod));
  const double across = rod.properties.inertia_m2(0, 0), along = rod.properties.inertia_m2(1, 1);
  const Vector3d momentum(5 * across, 400 * along, 0);  // per unit mass
  run_seconds(world, 2.0);
  const Vector3d axis =
      Eigen::AngleAxisd(2.0 * momentum.norm() / across, momentum.normalized()) * Vector3d::UnitY();
  EXPECT_LT((body_state(world, 1).world_from_body.orientation * Vector3d::UnitY() - axis).norm(), 1e-6);
}

TEST(RigidMotion, DzhanibekovConservesEnergyAndMomentum) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4, Vector3d::Zero());
    // The moments are proportional to b²+c² : a²+c² : a²+b². Rotation about the middle one, y here, is
    // unstable.
    auto box = box_body(1, {0.3, 0.2, 0.05}, 1.0);
    box.angular_velocity_rad_s = {0.01, 10, 0.01};
    ASSERT_TRUE(world.add_rigid(box));
    const BodyEnergy before = world.energy();
    double least = 10.0;
    for (int i = 0; i < 60 * rate; ++i) {
      world.step();
      const BodyState state = body_state(world, 1);
      least =
          std::min(least, (state.world_from_body.orientation.conjugate() * state.angular_velocity_rad_s).y());
      // A symmetric splitting (rotate_freely): the energy error stays bounded. Bar of scene 9.
      ASSERT_NEAR(world.energy().kinetic_j / before.kinetic_j, 1.0, 1e-3);
    }
    EXPECT_LT(
        (world.energy().angular_momentum - before.angular_momentum).norm() / before.angular_momentum.norm(),
        1e-12);  // constant by construction; rounding only
    EXPECT_LT(least, -9.0) << "the spin about the middle axis did not flip";
  }
}

// Time of the first flip by Euler's equations, integrated with fourth-order Runge-Kutta in body axes as an
// independent reference.
double first_flip_s(const Vector3d& moments, Vector3d omega) {
  const auto slope = [&](const Vector3d& w) {
    return Vector3d((moments.y() - moments.z()) * w.y() * w.z() / moments.x(),
                    (moments.z() - moments.x()) * w.z() * w.x() / moments.y(),
                    (moments.x() - moments.y()) * w.x() * w.y() / moments.z());
  };
  constexpr double h = 1e-4;
  double time = 0.0;
  while (omega.y() > 0.0 && time < 60.0) {
    const Vector3d a = slope(omega), b = slope(omega + 0.5 * h * a), c = slope(omega + 0.5 * h * b),
                   d = slope(omega + h * c);
    omega += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    time += h;
  }
  return time;
}

TEST(RigidMotion, DzhanibekovFlipMatchesRungeKutta) {
  for (const double rate : kRates_hz) {
    SCOPED_TRACE(rate);
    World world = world_at(rate, 4, Vector3d::Zero());
    auto box = box_body(1, {0.3, 0.2, 0.05}, 1.0);
    box.angular_velocity_rad_s = {0.01, 10, 0.01};
    ASSERT_TRUE(world.add_rigid(box));
    const double expected = first_flip_s(box.properties.inertia_m2.diagonal(), box.angular_velocity_rad_s);
    double flip = 0.0;
    for (int i = 0; i < 60 * rate && flip == 0.0; ++i) {
      world.step();
      const BodyState state = body_state(world, 1);
      if ((state.world_from_body.orientation.conjugate() * state.angular_velocity_rad_s).y() < 0.0) {
        flip = static_cast<double>(world.tick()) / rate;
      }
    }
    // 2 % (scene 9), plus the tick in which the flip is detected.
    EXPECT_NEAR(flip, expected, 0.02 * expected + 1.0 / rate);
  }
}

TEST(RigidMotion, MotionIsTheSameFarFromTheOrigin) {
  const Vector3d far(1000, 0, -1000);
  World near_world = world_at(60, 4), far_world = world_at(60, 4);
  for (World* world : {&near_world, &far_world}) {
    world->add_collider(floor_plane());
    auto box = box_body(1, {0.1, 0.06, 0.08}, 0.5);
    box.world_from_object.position_m = {0, 0.2, 0};
    box.world_from_object.orientation = Eigen::AngleAxisd(0.4, Vector3d(1, 1, 0).normalized());
    if (world == &far_world) box.world_from_object.position_m += far;
    ASSERT_TRUE(world->add_rigid(box));
    run_seconds(*world, 0.3);
  }
  const BodyState a = body_state(near_world, 1), b = body_state(far_world, 1);
  // Doubles at 1 km resolve 1e-13 m; 72 substeps and one impact amplify that.
  EXPECT_LT((a.world_from_body.position_m + far - b.world_from_body.position_m).norm(), 1e-8);
  run_seconds(far_world, 3.0);
  const BodyState rest = body_state(far_world, 1);
  EXPECT_TRUE(rest.asleep);
}

}  // namespace
}  // namespace livegs

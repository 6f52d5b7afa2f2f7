// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "scenes/elastic_bodies.h"
#include "scenes/rigid_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

TEST(WorldHands, SpringForceIsStiffnessTimesStretch) {
  for (const double rate : kRates_hz) {
    for (const double stiffness : {20.0, 200.0, 5000.0}) {
      World world = world_at(rate, 4);
      ASSERT_TRUE(world.add_rigid(box_body(1, {0.1, 0.1, 0.1}, 0.5)));
      World::Spring spring;
      spring.rest_point_m = {0, 0.05, 0};
      spring.target_m = {0, 0.1, 0};
      spring.stiffness_n_m = stiffness;
      world.set_spring(1, 1, spring);
      run_seconds(world, 8.0);
      const Vector3d stretch = spring.target_m - world.world_point(1, spring.rest_point_m);
      const Vector3d force = world.spring_force_n(1);
      EXPECT_NEAR(stretch.y() * stiffness, 0.5 * kGravity,
                  1e-6 * 0.5 * kGravity);  // the spring carries the weight: k x = m g
      EXPECT_LT((force - stiffness * stretch).norm(), 1e-6 * force.norm());
    }
  }
}

TEST(WorldHands, SpringOnAHeldDoorReportsItsPull) {
  World world = world_at(60, 4);
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.8, 2.0, 0.04}, 20.0)));
  ASSERT_TRUE(world.add_hinge_joint({1, {}, {-0.4, 0, 0}, Vector3d::UnitY()}));
  // A pull along the door against its hinge: the door does not move, and F = k x.
  World::Spring spring;
  spring.rest_point_m = {0.4, 0, 0};
  spring.target_m = {0.5, 0, 0};
  spring.stiffness_n_m = 100.0;
  world.set_spring(1, 1, spring);
  run_seconds(world, 2.0);
  EXPECT_NEAR(world.spring_force_n(1).x(), 10.0, 1e-5);
  EXPECT_NEAR(world.joints()[0].force_n, std::hypot(10.0, 20.0 * kGravity), 1e-3);
}

ElasticBodyDescription soft_cube() {
  auto cube = test::describe(test::particle_grid({0.2, 0.2, 0.2}, 0.025), 2e4, 0.3, 0.05, 300.0);
  cube.object_id = 1;
  return cube;
}

Pose hand_at(const Vector3d& position_m, double angle = 0.0) {
  return {position_m, Quaterniond(AngleAxisd(angle, Vector3d(1, 2, 3).normalized()))};
}

// A tilted object held by a corner in a rotated hand.
TEST(WorldHands, GrabHoldsARigidObjectWhereItIs) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4, Vector3d::Zero());
    auto box = box_body(1, {0.1, 0.2, 0.1}, 0.4);
    box.world_from_object.orientation = rotation_about(2);
    ASSERT_TRUE(world.add_rigid(box));
    const Vector3d corner = box.world_from_object * Vector3d(0.05, 0.1, 0.05);
    ASSERT_TRUE(world.grab(1, 1, hand_at(corner, 0.7), {}));
    run_seconds(world, 1.0);
    const BodyState state = body_state(world, 1);
    EXPECT_LT(state.world_from_body.position_m.norm(), 1e-12);
    EXPECT_LT(state.world_from_body.orientation.angularDistance(rotation_about(2)), 1e-7);
    EXPECT_LT(world.grab_state(1)->force_n.norm(), 1e-9);
  }
}

TEST(WorldHands, GrabCarriesWeightAndFollowsTheHand) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4);
    ASSERT_TRUE(world.add_rigid(box_body(1, {0.1, 0.2, 0.1}, 0.4)));
    World::Grip grip;
    ASSERT_TRUE(world.grab(1, 1, hand_at({0, 0.1, 0}), grip));
    run_seconds(world, 2.0);
    const double omega = 2.0 * std::numbers::pi * grip.frequency_hz;
    EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.y(), -kGravity / (omega * omega),
                1e-6);  // m g = k x
    EXPECT_NEAR(world.grab_state(1)->force_n.y(), 0.4 * kGravity, 1e-6);
    // A quarter turn within a second, then at rest.
    for (int i = 1; i <= std::lround(rate); ++i) {
      const double share = i / rate;
      world.move_grab(1, hand_at({0.3 * share, 0.1 + 0.2 * share, 0}, 0.5 * std::numbers::pi * share),
                      {0.3, 0.2, 0}, 0.5 * std::numbers::pi * Vector3d(1, 2, 3).normalized());
      world.step();
    }
    // The damping includes the target's velocity, so the object lags only by its weight and by one tick of
    // the hand's motion.
    EXPECT_LT((world.grab_state(1)->point_m - Vector3d(0.3, 0.3 - kGravity / (omega * omega), 0)).norm(),
              0.01);
    world.move_grab(1, hand_at({0.3, 0.3, 0}, 0.5 * std::numbers::pi), Vector3d::Zero(), Vector3d::Zero());
    run_seconds(world, 2.0);
    const Quaterniond turned(AngleAxisd(0.5 * std::numbers::pi, Vector3d(1, 2, 3).normalized()));
    // The weight, at most 0.1 m from the grip, twists the object by m g r / (I omega²).
    EXPECT_LT(body_state(world, 1).world_from_body.orientation.angularDistance(turned),
              1.5 * kGravity * 0.1 / ((0.2 * 0.2 + 0.1 * 0.1) / 12.0 * omega * omega));
    EXPECT_NEAR((world.grab_state(1)->point_m - Vector3d(0.3, 0.3 - kGravity / (omega * omega), 0)).norm(), 0,
                1e-4);
  }
}

TEST(WorldHands, ReleaseThrowsAtTheHandsVelocity) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4);
    ASSERT_TRUE(world.add_rigid(box_body(1, {0.1, 0.1, 0.1}, 0.3)));
    ASSERT_TRUE(world.grab(1, 1, hand_at({0, 0.05, 0}), {}));
    // Half a second of constant acceleration to 3 m/s, then the hand releases.
    const Vector3d acceleration(6, 2, 0);
    const int ticks = static_cast<int>(0.5 * rate);
    for (int i = 0; i < ticks; ++i) {
      const double time = i / rate;
      world.move_grab(1, hand_at(Vector3d(0, 0.05, 0) + 0.5 * time * time * acceleration),
                      time * acceleration, Vector3d::Zero());
      world.step();
    }
    world.release_grab(1);
    EXPECT_FALSE(world.grab_state(1));
    // Under a steady acceleration the object lags by a constant distance, so it has the hand's velocity. 5 %
    // allow for tick sampling.
    const Vector3d hand = 0.5 * acceleration;
    const BodyState state = body_state(world, 1);
    EXPECT_LT((state.velocity_m_s - hand).norm(), 0.05 * hand.norm()) << state.velocity_m_s.transpose();
  }
}

TEST(WorldHands, TwoHandsTurnOneObject) {
  World world = world_at(60, 4);
  ASSERT_TRUE(world.add_rigid(box_body(1, {1.0, 0.05, 0.05}, 1.0)));
  World::Grip grip;
  grip.max_torque_n_m = 20.0;  // one hand alone carries 4.9 N m
  ASSERT_TRUE(world.grab(1, 1, hand_at({-0.5, 0, 0}), grip));
  ASSERT_TRUE(world.grab(2, 1, hand_at({0.5, 0, 0}), grip));
  run_seconds(world, 1.0);
  const double weight = world.grab_state(1)->force_n.y() + world.grab_state(2)->force_n.y();
  EXPECT_NEAR(weight, kGravity, 1e-5);
  // Each hand moves a quarter turn about the middle and rotates with it.
  for (int i = 1; i <= 60; ++i) {
    const Quaterniond turn(AngleAxisd(0.5 * std::numbers::pi * i / 60.0, Vector3d::UnitY()));
    world.move_grab(1, {turn * Vector3d(-0.5, 0, 0), turn}, Vector3d::Zero(), Vector3d::Zero());
    world.move_grab(2, {turn * Vector3d(0.5, 0, 0), turn}, Vector3d::Zero(), Vector3d::Zero());
    world.step();
  }
  run_seconds(world, 1.0);
  const Vector3d along = body_state(world, 1).world_from_body.orientation * Vector3d::UnitX();
  EXPECT_LT((along - Vector3d(0, 0, -1)).norm(), 1e-3);
  // After one hand releases, the object stays in the other.
  world.release_grab(1);
  run_seconds(world, 2.0);
  EXPECT_LT(body_state(world, 1).velocity_m_s.norm(), 1e-3);
}

// A hand whose position jumps in each tick or is not finite.
TEST(WorldHands, JumpingHandsStayWithinTheForceBound) {
  World world = world_at(60, 4);
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.05, 0.05, 0.05}, 0.05)));
  World::Grip grip;
  grip.max_force_n = 10.0;
  grip.max_torque_n_m = 0.2;
  ASSERT_TRUE(world.grab(1, 1, hand_at({0, 0, 0}), grip));
  for (int i = 0; i < 300; ++i) {
    const Vector3d before = body_state(world, 1).velocity_m_s;
    const Vector3d far(i % 2 == 0 ? 900.0 : -900.0, 500.0 * std::sin(1.0 * i), 1000.0 * std::cos(2.0 * i));
    world.move_grab(1, {far, rotation_about(i)}, {0, i % 3 == 0 ? 1e3 : -1e3, 0}, {100, 0, -100});
    world.step();
    const Vector3d change = body_state(world, 1).velocity_m_s - before;
    ASSERT_LE(change.norm(), (10.0 / 0.05 + kGravity) / 60.0 * 1.001);
    ASSERT_LE(world.grab_state(1)->force_n.norm(), 10.0 * (1 + 1e-12));
    ASSERT_LE(world.grab_state(1)->torque_n_m.norm(), 0.2 * (1 + 1e-12));
  }
  const Vector3d at = world.grab_state(1)->point_m;
  world.move_grab(1, {Vector3d(NAN, 0, 0), Quaterniond::Identity()}, Vector3d::Zero(), Vector3d::Zero());
  world.move_grab(1, hand_at(at), Vector3d(INFINITY, 0, 0), Vector3d::Zero());
  world.move_grab(1, {at, Quaterniond(0, 0, 0, 0)}, Vector3d::Zero(), Vector3d::Zero());
  world.move_grab(9, hand_at(at), Vector3d::Zero(), Vector3d::Zero());
  world.step();
  EXPECT_TRUE(body_state(world, 1).velocity_m_s.allFinite());
}

TEST(WorldHands, HeldBoxReportsItsImpactOnATable) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4);
    world.add_collider(floor_plane());
    auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
    box.world_from_object.position_m.y() = 0.3;
    ASSERT_TRUE(world.add_rigid(box));
    World::Grip soft;
    soft.frequency_hz = 1.0;
    ASSERT_TRUE(world.grab(1, 1, hand_at({0, 0.35, 0}), soft));
    // The hand moves down through the table at 1 m/s.
    double largest = 0.0, before = 0.0, sum = 0.0, after = 0.0;
    for (int i = 0; i < std::lround(0.5 * rate); ++i) {
      const double speed = -body_state(world, 1).velocity_m_s.y();
      world.move_grab(1, hand_at({0, 0.35 - i / rate, 0}), {0, -1, 0}, Vector3d::Zero());
      world.step();
      const double impulse = world.contact_impulse_n_s(1, Vector3d::Zero());
      if (impulse > largest) {
        largest = impulse;
        before = speed;
        after = -body_state(world, 1).velocity_m_s.y();
      }
      sum += impulse;
    }
    // The box stops without restitution: m v, plus the impulse of weight and hand within the tick, at most 50
    // N.
    EXPECT_GT(before, 0.5);
    EXPECT_NEAR(after, 0.0, 0.01);
    EXPECT_GE(largest, 0.5 * before * 0.999);
    EXPECT_LE(largest, 0.5 * before + (0.5 * kGravity + 5.0) / rate);
    EXPECT_GE(sum, largest);
    // In the air again the box has no contact impulse.
    for (int i = 0; i < std::lround(2.0 * rate); ++i) {
      world.move_grab(1, hand_at({0, 0.6, 0}), Vector3d::Zero(), Vector3d::Zero());
      world.step();
    }
    EXPECT_EQ(world.contact_impulse_n_s(1, Vector3d::Zero()), 0.0);
  }
}

TEST(WorldHands, GrabHoldsAndCarriesASoftObject) {
  World world = world_at(60, 4);
  auto cube = soft_cube();
  ASSERT_TRUE(world.add_elastic(cube));
  const Vector3d start = world.elastic_body(1)->centre_m();
  World::Grip grip;
  grip.frequency_hz = 5.0;
  ASSERT_TRUE(world.grab(1, 1, hand_at({0, 0.1, 0}), grip));
  EXPECT_LT(world.grab_state(1)->force_n.norm(), 1e-9);
  run_seconds(world, 2.0);
  const double weight = world.elastic_body(1)->mass_kg() * kGravity;
  EXPECT_NEAR(world.grab_state(1)->force_n.y() / weight, 1.0, 0.05);
  for (int i = 1; i <= 60; ++i) {
    world.move_grab(1, hand_at({0.005 * i, 0.1 + 0.005 * i, 0}), {0.3, 0.3, 0}, Vector3d::Zero());
    world.step();
  }
  world.move_grab(1, hand_at({0.3, 0.4, 0}), Vector3d::Zero(), Vector3d::Zero());
  run_seconds(world, 2.0);
  EXPECT_NEAR(world.elastic_body(1)->centre_m().x() - start.x(), 0.3, 0.05);
  EXPECT_NEAR(world.elastic_body(1)->centre_m().y() - start.y(), 0.3, 0.08);
  world.release_grab(1);
  run_seconds(world, 0.5);
  EXPECT_LT(world.elastic_body(1)->centre_m().y() - start.y(), -0.5);
}

// Object ids may be reused. Grabs and forces of the removed object must not affect the new one.
TEST(WorldHands, RemovedObjectIsReleased) {
  World world = world_at(90, 4, Vector3d::Zero());
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.1, 0.1, 0.1}, 0.5)));
  ASSERT_TRUE(world.add_rigid(box_body(2, {0.1, 0.1, 0.1}, 0.5)));
  for (const uint32_t id : {1u, 2u}) {
    world.set_force(id, id, {{0, 0, 0}, {0, 1, 0}});
    world.set_spring(id, id, {{0, 0, 0}, {1, 0, 0}});
    ASSERT_TRUE(world.grab(id, id, hand_at({0, 0, 0}), {}));
    world.move_grab(id, hand_at({0, 0, 1}), Vector3d::Zero(), Vector3d::Zero());
  }
  world.step();
  world.remove(1);
  EXPECT_FALSE(world.grab_state(1));
  EXPECT_TRUE(world.grab_state(2));
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.1, 0.1, 0.1}, 0.5)));
  run_seconds(world, 0.1);
  EXPECT_EQ(body_state(world, 1).velocity_m_s, Vector3d::Zero());
  EXPECT_EQ(world.spring_force_n(1), Vector3d::Zero());
  for (int axis = 0; axis < 3; ++axis) EXPECT_GT(body_state(world, 2).velocity_m_s[axis], 0.01);
}

TEST(WorldHands, NearestFindsObjectsWithinReach) {
  World world = world_at(60, 4);
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.1, 0.1, 0.1}, 0.5)));
  ASSERT_TRUE(world.add_ball(ball(2, {0.3, 0, 0})));
  EXPECT_EQ(world.nearest({0.08, 0, 0}, 0.1)->object_id, 1u);
  EXPECT_NEAR(world.nearest({0.08, 0, 0}, 0.1)->distance_m, 0.03, 0.005);  // distance from a grid
  EXPECT_EQ(world.nearest({0.0, 0, 0}, 0.1)->distance_m, 0.0);
  EXPECT_EQ(world.nearest({0.22, 0, 0}, 0.1)->object_id, 2u);
  EXPECT_FALSE(world.nearest({0, 0.3, 0}, 0.1));
}

}  // namespace
}  // namespace livegs

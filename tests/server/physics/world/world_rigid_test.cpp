// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "scenes/rigid_fixtures.h"

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

const Vector3d kNoGravity = Vector3d::Zero();

TEST(World, BallAndBodyConserveMomentum) {
  for (int aim = 0; aim < 6; ++aim) {
    World world = world_at(60, 4, kNoGravity);
    auto box = box_body(1, {0.2, 0.1, 0.15}, 1.0);
    box.world_from_object.orientation = rotation_about(aim);
    ASSERT_TRUE(world.add_rigid(box));
    auto description = ball(2, {0.5, 0.02 * aim, 0.01 * aim}, 0.04, 0.2);
    description.velocity_m_s = {-3, 0, 0};
    description.restitution = 0.5;
    ASSERT_TRUE(world.add_ball(description));
    const BodyEnergy before = world.energy();
    run_seconds(world, 0.5);
    const BodyEnergy after = world.energy();
    EXPECT_GT(body_state(world, 1).velocity_m_s.norm(), 0.1) << "no collision";
    // Impulses are equal and opposite at one point, so only rounding is left.
    EXPECT_LT((after.linear_momentum - before.linear_momentum).norm(), 1e-12);
    EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-12);
    EXPECT_LE(after.kinetic_j, before.kinetic_j);
  }
}

TEST(World, CentralImpactMatchesTheClosedForm) {
  World world = world_at(60, 4, kNoGravity);
  auto box = box_body(1, {0.2, 0.2, 0.2}, 1.0);
  ASSERT_TRUE(world.add_rigid(box));
  auto description = ball(2, {-0.6, 0, 0}, 0.05, 0.5);
  description.velocity_m_s = {4, 0, 0};
  description.restitution = 0.6;
  ASSERT_TRUE(world.add_ball(description));
  run_seconds(world, 0.5);
  // v = m1 v0 (1 + e) / (m1 + m2). The face is flat and the contact is away from its edges, so the distance
  // field is exact.
  EXPECT_NEAR(body_state(world, 1).velocity_m_s.x(), 0.5 * 4 * 1.6 / 1.5, 1e-3);
  EXPECT_NEAR(body_state(world, 2).velocity_m_s.x(), 4 * (0.5 - 0.6) / 1.5, 1e-3);
}

TEST(World, EqualBallsExchangeVelocities) {
  World world = world_at(60, 4, kNoGravity);
  for (uint32_t id : {1u, 2u}) {
    auto description = ball(id, {id == 1 ? -0.3 : 0.0, 0, 0}, 0.05, 0.2);
    description.restitution = 1.0;
    if (id == 1) description.velocity_m_s = {2, 0, 0};
    ASSERT_TRUE(world.add_ball(description));
  }
  run_seconds(world, 0.5);
  EXPECT_NEAR(body_state(world, 1).velocity_m_s.x(), 0.0, 1e-9);
  EXPECT_NEAR(body_state(world, 2).velocity_m_s.x(), 2.0, 1e-9);
}

TEST(World, FastBallDoesNotPassABody) {
  for (const double rate : kRates_hz)
    for (const double speed : {5.0, 20.0, 60.0}) {
      World world = world_at(rate, 4, kNoGravity);
      ASSERT_TRUE(world.add_rigid(box_body(1, {0.3, 0.3, 0.02}, 1.0)));
      auto description = ball(2, {0.02, 0.03, 0.7}, 0.03, 0.05);
      description.velocity_m_s = {0, 0, -speed};
      ASSERT_TRUE(world.add_ball(description));
      for (int i = 0; i < rate / 2; ++i) {
        world.step();
        // The plate rotates after an off-centre impact, so the ball is checked in the plate's frame while it
        // is above the plate.
        const Vector3d seen =
            body_state(world, 1).world_from_body.inverse() * body_state(world, 2).world_from_body.position_m;
        if (std::abs(seen.x()) < 0.15 && std::abs(seen.y()) < 0.15) {
          EXPECT_GT(seen.z(), 0.035) << speed << " tick " << i;
        }
      }
      EXPECT_LT(body_state(world, 1).velocity_m_s.z(), 0.0);
    }
}

TEST(World, BallComesToRestOnABodyAndBothSleep) {
  World world = world_at(60, 4);
  world.add_collider(floor_plane(0.8));
  auto box = box_body(1, {0.3, 0.1, 0.3}, 2.0);
  box.world_from_object.position_m = {0, 0.05, 0};
  ASSERT_TRUE(world.add_rigid(box));
  ASSERT_TRUE(world.add_ball(ball(2, {0, 0.155, 0}, 0.05, 0.2)));
  run_seconds(world, 3.0);
  EXPECT_TRUE(body_state(world, 1).asleep);
  EXPECT_TRUE(body_state(world, 2).asleep);
  EXPECT_NEAR(body_state(world, 2).world_from_body.position_m.y(), 0.15, 1e-3);
  // The ball falls once its support is removed.
  world.remove(1);
  run_seconds(world, 0.5);
  EXPECT_NEAR(body_state(world, 2).world_from_body.position_m.y(), 0.05, 1e-3);
}

TEST(World, ImpactWakesSleepingBody) {
  World world = world_at(60, 4);
  world.add_collider(floor_plane());
  auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
  box.world_from_object.position_m = {0, 0.05, 0};
  ASSERT_TRUE(world.add_rigid(box));
  run_seconds(world, 2.0);
  ASSERT_TRUE(body_state(world, 1).asleep);
  world.take_events();
  auto description = ball(2, {-0.5, 0.06, 0}, 0.04, 0.3);
  description.velocity_m_s = {4, 0, 0};
  ASSERT_TRUE(world.add_ball(description));
  run_seconds(world, 0.3);
  EXPECT_GT(body_state(world, 1).world_from_body.position_m.x(), 0.05);
  const auto events = world.take_events();
  EXPECT_TRUE(std::any_of(events.begin(), events.end(), [](const WorldEvent& event) {
    return event.kind == WorldEventKind::Wake && event.object_id == 1;
  }));
}

TEST(World, ContactEventsSumToTheStoppedMomentum) {
  World world = world_at(60, 4, kNoGravity);
  world.add_collider(floor_plane());
  auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
  box.world_from_object.position_m = {0, 0.3, 0};
  box.velocity_m_s = {0, -3, 0};
  ASSERT_TRUE(world.add_rigid(box));
  run_seconds(world, 0.5);
  double impulse = 0.0;
  for (const WorldEvent& event : world.take_events()) {
    if (event.kind != WorldEventKind::Contact) continue;
    impulse += event.impulse_n_s;
    EXPECT_NEAR(event.point_m.y(), 0.0, 2e-3);
  }
  // m v, counted once: not again in relax passes or substeps. The contact spring separates rounding overlaps,
  // hence 1 %.
  EXPECT_NEAR(impulse, 1.5, 0.015);
}

TEST(World, RestingWeightIsReportedEachTick) {
  WorldSettings settings;
  settings.rate_hz = 60.0;
  settings.sleep = false;
  World world(settings);
  world.add_collider(floor_plane());
  auto box = box_body(1, {0.2, 0.2, 0.2}, 4.0);
  box.world_from_object.position_m = {0, 0.1, 0};
  ASSERT_TRUE(world.add_rigid(box));
  run_seconds(world, 2.0);
  world.take_events();
  world.step();
  const auto events = world.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_NEAR(events[0].impulse_n_s, 4.0 * kGravity / 60.0, 1e-4);  // m g dt
}

TEST(World, SpringPullsPointToTargetAndReportsForce) {
  World world = world_at(60, 4);
  auto box = box_body(1, {0.1, 0.1, 0.1}, 0.5);
  ASSERT_TRUE(world.add_rigid(box));
  World::Spring spring;
  spring.rest_point_m = {0, 0.05, 0};
  spring.target_m = {0.2, 0.4, 0};
  spring.stiffness_n_m = 200.0;
  world.set_spring(7, 1, spring);
  run_seconds(world, 6.0);
  // The point hangs below the target by m g / k.
  const double sag = 0.5 * kGravity / 200.0;
  EXPECT_LT((world.world_point(1, spring.rest_point_m) - (spring.target_m - Vector3d(0, sag, 0))).norm(),
            5e-3);
  EXPECT_NEAR(world.spring_force_n(7).y(), 0.5 * kGravity, 0.02 * 0.5 * kGravity);
  world.clear_spring(7);
  EXPECT_EQ(world.spring_force_n(7).norm(), 0.0);
}

TEST(World, SpringForceIsBoundedAndStableOnTinyMasses) {
  World world = world_at(60, 4, kNoGravity);
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.02, 0.02, 0.02}, 0.001)));
  World::Spring spring;
  spring.rest_point_m = {0.01, 0.01, 0.01};
  spring.target_m = {0.02, 0.01, 0.01};
  spring.stiffness_n_m = 1e4;  // h² k / m = 174, far beyond the limit of an explicit spring
  spring.max_force_n = 20.0;
  world.set_spring(1, 1, spring);
  for (int i = 0; i < 240; ++i) {
    world.step();
    EXPECT_LE(world.spring_force_n(1).norm(), 20.0 * (1.0 + 1e-12));
  }
  EXPECT_LT((world.world_point(1, spring.rest_point_m) - spring.target_m).norm(), 1e-3);
}

TEST(World, ForceAcceleratesAndEnds) {
  World world = world_at(90, 4, kNoGravity);
  ASSERT_TRUE(world.add_rigid(box_body(1, {0.1, 0.1, 0.1}, 2.0)));
  world.set_force(3, 1, {Vector3d::Zero(), {4, 0, 0}}, 0.5);
  run_seconds(world, 0.5);
  run_seconds(world, 0.5);
  EXPECT_NEAR(body_state(world, 1).velocity_m_s.x(), 1.0, 1e-12);
  EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.x(), 0.25 + 0.5, 1e-12);
}

TEST(World, RayHitsTheNearestObject) {
  World world = world_at(60, 4, kNoGravity);
  auto box = box_body(1, {0.2, 0.2, 0.2}, 1.0);
  box.world_from_object.position_m = {0, 0, -2};
  box.world_from_object.orientation = Eigen::AngleAxisd(radians(90), Vector3d::UnitY());
  ASSERT_TRUE(world.add_rigid(box));
  ASSERT_TRUE(world.add_ball(ball(2, {0, 0, -3}, 0.3)));
  const auto hit = world.ray_cast({0.05, 0.02, 0}, {0, 0, -1}, 10.0);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->object_id, 1u);
  EXPECT_NEAR(hit->distance_m, 1.9, 1e-12);
  EXPECT_LT((world.world_point(1, hit->rest_point_m) - Vector3d(0.05, 0.02, -1.9)).norm(), 1e-12);
  const auto past_box = world.ray_cast({0.15, 0, 0}, {0, 0, -1}, 10.0);
  ASSERT_TRUE(past_box);
  EXPECT_EQ(past_box->object_id, 2u);
  EXPECT_NEAR(past_box->distance_m, 3.0 - std::sqrt(0.09 - 0.0225), 1e-12);
  EXPECT_FALSE(world.ray_cast({0.15, 0, 0}, {0, 0, -1}, 1.0));
  EXPECT_FALSE(world.ray_cast({5, 0, 0}, {0, 0, -1}, 10.0));
}

TEST(World, DriversAndRestBodiesPlaceTheObjectFrame) {
  World world = world_at(60, 4);
  TriangleMesh mesh = box_mesh({0.1, 0.1, 0.1});
  for (Vector3d& vertex : mesh.vertices_m)
    vertex += Vector3d(0.3, 0.1, 0);  // the centre of mass is away from the origin
  auto box = body_of(5, mesh, 1.0);
  box.world_from_object.position_m = {1, 2, 3};
  box.world_from_object.orientation = rotation_about(3);
  ASSERT_TRUE(world.add_rigid(box));
  const Pose fixed{{0, 1, 0}, rotation_about(2)};
  ASSERT_TRUE(world.add_static(2, fixed));
  const DriverFrame frame = world.drivers();
  ASSERT_EQ(frame.objects.size(), 2u);
  EXPECT_EQ(frame.objects[0].object_id, 2u);
  EXPECT_TRUE(frame.objects[0].asleep);
  EXPECT_EQ(frame.objects[1].object_id, 5u);
  const Pose object_from_body = world.rest_body(5).bodies.at(0);
  const Vector3d point(0.31, 0.12, 0.01);
  // Skinning computes driver * body_from_object * point.
  EXPECT_LT(
      (frame.objects[1].poses.at(0) * (object_from_body.inverse() * point) - box.world_from_object * point)
          .norm(),
      1e-12);
  EXPECT_LT((world.world_point(5, point) - box.world_from_object * point).norm(), 1e-12);
  EXPECT_LT((world.world_point(2, point) - fixed * point).norm(), 1e-12);
  run_seconds(world, 1.0);
  EXPECT_LT((world.drivers().objects[0].poses.at(0).position_m - fixed.position_m).norm(), 1e-15);
  EXPECT_EQ(world.drivers().simulated_ns, 1'000'000'000);
}

TEST(World, RejectsUnphysicalInputAndNamesIt) {
  World world = world_at(60, 4);
  const auto message = [](const Result<void>& result) {
    return result ? std::string() : result.error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto box = box_body(9, {0.1, 0.1, 0.1}, 1.0);
  const auto refused = [&](auto change, const std::string& field) {
    RigidBodyDescription copy = box;
    change(copy);
    const std::string text = message(world.add_rigid(copy));
    EXPECT_NE(text.find("object 9"), std::string::npos) << text;
    EXPECT_NE(text.find(field), std::string::npos) << text;
  };
  refused([](auto& d) { d.material.mass_kg = 0.0; }, "mass_kg");
  refused([&](auto& d) { d.material.mass_kg = nan; }, "mass_kg");
  refused([](auto& d) { d.material.friction = -0.1; }, "friction");
  refused([](auto& d) { d.material.restitution = 1.5; }, "restitution");
  refused([](auto& d) { d.material.poisson_ratio = 0.5; }, "poisson_ratio");
  refused([](auto& d) { d.material.youngs_modulus_pa = 0; }, "youngs_modulus_pa");
  refused([&](auto& d) { d.velocity_m_s.x() = nan; }, "velocity_m_s");
  refused([&](auto& d) { d.world_from_object.position_m.x() = nan; }, "position_m");
  refused([](auto& d) { d.world_from_object.orientation.w() = 3.0; }, "orientation");
  refused([](auto& d) { d.mesh.triangles.clear(); }, "mesh");
  refused([](auto& d) { d.mesh.triangles[0][1] = 99; }, "mesh");
  refused([](auto& d) { d.properties.inertia_m2.setZero(); }, "inertia");
  refused([](auto& d) { d.properties.inertia_m2(2, 2) *= 10.0; }, "inertia");
  ASSERT_TRUE(world.add_rigid(box));
  refused([](auto&) {}, "already in use");

  auto sphere = ball(4, Vector3d::Zero());
  sphere.radius_m = 0.0;
  EXPECT_NE(message(world.add_ball(sphere)).find("object 4: radius_m"), std::string::npos);
  EXPECT_NE(message(world.set_material(77, {})).find("object 77"), std::string::npos);
  Material elastic;
  elastic.behavior = Behavior::Elastic;
  elastic.mass_kg = 1.0;
  EXPECT_NE(message(world.set_material(9, elastic)).find("behavior"), std::string::npos);
  Material heavier = box.material;
  heavier.mass_kg = 3.0;
  EXPECT_TRUE(world.set_material(9, heavier));
  EXPECT_EQ(body_state(world, 9).mass_kg, 3.0);
  world.remove(1234);
  world.set_force(1, 1234, {});
}

}  // namespace
}  // namespace livegs

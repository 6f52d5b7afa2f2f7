// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "known_gaps.h"
#include "scenes/rigid_fixtures.h"

// Bodies and colliders that are not boxes: round meshes, and floors given by distance fields.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

Collider field_collider(const TriangleMesh& mesh, double cell_m, const Vector3d& position_m) {
  Collider collider{FieldShape{std::make_shared<DistanceField>(mesh, cell_m, 4 * cell_m)}, Pose{}, 0.5, 0.0};
  collider.world_from_collider.position_m = position_m;
  return collider;
}

TEST(RigidShapes, RoundMeshesComeToRestOnTheFloor) {
  const double r = 0.05;
  const std::pair<TriangleMesh, double> cases[] = {
      {sphere_mesh(r, 3), r}, {cylinder_mesh(r, 0.1), 0.05}, {capsule_mesh(0.03, 0.1), 0.03}};
  for (const auto& [mesh, lowest] : cases) {
    World world = world_at(60, 4);
    world.add_collider(floor_plane());
    auto body = body_of(1, mesh, 0.3);
    body.world_from_object.position_m = {0, 0.25, 0};
    body.world_from_object.orientation = Eigen::AngleAxisd(0.3, Vector3d::UnitX());
    ASSERT_TRUE(world.add_rigid(body));
    run_seconds(world, 8.0);
    const BodyState state = body_state(world, 1);
    EXPECT_TRUE(state.world_from_body.position_m.allFinite());
    // At least half its width less the sag and the facets (1 % of the radius at 32 segments), at most half
    // its length.
    EXPECT_GT(state.world_from_body.position_m.y(), 0.985 * lowest);
    EXPECT_LT(state.world_from_body.position_m.y(), 0.085);
    EXPECT_LT(state.velocity_m_s.norm(), 0.05);
  }
}

// Speed after `seconds` of a prism that rolls from rest. Each landing facet dissipates a share of the energy,
// and gravity adds energy between landings. With I = m r² / 2 about the axis, angular momentum about the new
// edge leaves (1 + 2 cos a) / 3 of the spin, a = 2 pi / facets.
double rolling_prism_speed(double angle_rad, double radius_m, int facets, double seconds) {
  const double turn = 2.0 * std::numbers::pi / facets;
  const double left = (1.0 + 2.0 * std::cos(turn)) / 3.0, facet = 2.0 * radius_m * std::sin(0.5 * turn);
  double speed = 0.0, time = 0.0;
  while (time < seconds) {
    const double faster =
        std::sqrt(speed * speed + 2.0 * (2.0 / 3.0) * kGravity * std::sin(angle_rad) * facet);
    time += 2.0 * facet / (speed + faster);
    speed = faster * left;
  }
  return speed;
}

TEST(RigidShapes, FacettedCylinderRollsLikeItsPrism) {
  const double angle = radians(10), r = 0.05;
  for (const double rate : kRates_hz)
    for (const int facets : {48, 96, 144}) {
      SCOPED_TRACE(::testing::Message() << facets << " facets at " << rate << " Hz");
      World world = world_at(rate, 4);
      world.add_collider(incline(angle, 0.6));
      auto body = body_of(1, cylinder_mesh(r, 0.1, facets), 0.5);
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(-angle, Vector3d::UnitZ()));
      body.world_from_object.orientation = turn * Eigen::AngleAxisd(radians(90), Vector3d::UnitX());
      body.world_from_object.position_m = turn * Vector3d(0, r, 0);
      ASSERT_TRUE(world.add_rigid(body));
      run_seconds(world, 1.0);
      // At 4 substeps one or two facets land within each substep.
      const double share =
          body_state(world, 1).velocity_m_s.norm() / rolling_prism_speed(angle, r, facets, 1.0);
      report_gap("shapes.facetted_roll", std::abs(share - 1.0));
      EXPECT_GT(share, 0.5);
    }
}

// With its exact surface a mesh of 32 facets rolls without losing speed: a = g sin(angle) / (1 + I / (m
// r^2)).
TEST(RigidShapes, RoundShapesRollLikeCylinders) {
  const double r = 0.1, height = 0.2, seconds = 1.5;
  const double side = height, caps = 4.0 / 3.0 * r;  // volume over pi r^2
  for (const double rate : kRates_hz) {
    for (const bool capsule : {false, true}) {
      for (const double degrees : {2.0, 5.0, 10.0, 20.0}) {
        for (const bool on_box : {false, true}) {
          SCOPED_TRACE(::testing::Message() << (capsule ? "capsule" : "cylinder") << " on " << degrees
                                            << " degrees" << (on_box ? ", box, " : ", ") << rate << " Hz");
          World world = world_at(rate, 4);
          const double angle = radians(degrees);
          Collider slope = incline(angle, 1.0);
          const Eigen::Quaterniond turn(Eigen::AngleAxisd(-angle, Vector3d::UnitZ()));
          if (on_box)
            slope = Collider{BoxShape{{20.0, 1.0, 2.0}}, Pose{turn * Vector3d(0, -0.5, 0), turn}, 1.0, 0.0};
          world.add_collider(slope);
          auto body = body_of(1, capsule ? capsule_mesh(r, height) : cylinder_mesh(r, height), 1.0);
          body.round = RoundShape{};
          body.round->kind = capsule ? RoundShape::Kind::Capsule : RoundShape::Kind::Cylinder;
          body.round->radius_m = r;
          body.round->half_length_m = 0.5 * height;
          body.material.friction = 1.0;
          body.material.restitution = 0.0;
          body.world_from_object.orientation = turn * Eigen::AngleAxisd(radians(90), Vector3d::UnitX());
          body.world_from_object.position_m = turn * Vector3d(0, r, 0);
          ASSERT_TRUE(world.add_rigid(body));
          run_seconds(world, seconds);
          const double inertia = capsule ? (0.5 * side + 0.4 * caps) / (side + caps) : 0.5;
          const double way = 0.5 * kGravity * std::sin(angle) / (1.0 + inertia) * seconds * seconds;
          const Vector3d moved = body_state(world, 1).world_from_body.position_m - turn * Vector3d(0, r, 0);
          EXPECT_NEAR(moved.norm() / way, 1.0, 0.02);
        }
      }
    }
  }
}

// Upright, tilted by less than it takes to fall, a cylinder returns to its flat end.
TEST(RigidShapes, RoundCylinderStandsOnItsEnd) {
  for (const double rate : kRates_hz) {
    World world = world_at(rate, 4);
    world.add_collider(floor_plane(0.6));
    auto body = body_of(1, cylinder_mesh(0.05, 0.1), 0.5);
    body.round = RoundShape{};
    body.round->radius_m = body.round->half_length_m = 0.05;
    body.world_from_object.orientation = Eigen::AngleAxisd(0.1, Vector3d(1, 0, 0.3).normalized());
    body.world_from_object.position_m = {0, 0.06, 0};
    ASSERT_TRUE(world.add_rigid(body));
    run_seconds(world, 5.0);
    const BodyState state = body_state(world, 1);
    EXPECT_TRUE(state.asleep);
    EXPECT_NEAR(state.world_from_body.position_m.y(), 0.05, 2e-4);
    EXPECT_GT((state.world_from_body.orientation * Vector3d::UnitY()).y(), 0.99999);
  }
}

TEST(RigidShapes, BoxRestsOnDistanceFieldAsOnBox) {
  World world = world_at(60, 4);
  world.add_collider(field_collider(box_mesh({1.0, 0.2, 1.0}), 0.02, {0, -0.1, 0}));
  auto box = box_body(1, {0.1, 0.06, 0.14}, 0.5);
  box.world_from_object.position_m = {0.013, 0.2, 0.007};
  box.world_from_object.orientation = rotation_about(4);
  ASSERT_TRUE(world.add_rigid(box));
  run_seconds(world, 4.0);
  const BodyState state = body_state(world, 1);
  EXPECT_TRUE(state.asleep);
  const double height = state.world_from_body.position_m.y();
  const double nearest =
      std::min({std::abs(height - 0.03), std::abs(height - 0.05), std::abs(height - 0.07)});
  EXPECT_LT(nearest, 5e-4);  // on one of its faces; the distance field of a flat face is exact
}

TEST(RigidShapes, FastBallDoesNotPassDistanceFieldWall) {
  for (const double rate : kRates_hz)
    for (const double speed : {3.0, 10.0, 40.0}) {
      World world = world_at(rate, 4, Vector3d::Zero());
      // Two cells thick: the thinnest wall that a distance field can represent.
      world.add_collider(field_collider(box_mesh({0.8, 0.8, 0.02}), 0.01, Vector3d::Zero()));
      auto description = ball(1, {0.05, 0.03, 0.9}, 0.03, 0.1);
      description.velocity_m_s = {0.02 * speed, 0, -speed};
      ASSERT_TRUE(world.add_ball(description));
      run_seconds(world, 0.5);
      EXPECT_GT(body_state(world, 1).world_from_body.position_m.z(), 0.0) << speed;
    }
}

TEST(RigidShapes, BallInACornerStaysInside) {
  World world = world_at(60, 4);
  world.add_collider(floor_plane());
  Collider wall = floor_plane();
  wall.world_from_collider.orientation =
      Eigen::AngleAxisd(radians(-90), Vector3d::UnitZ());  // solid at x <= 0
  world.add_collider(wall);
  auto description = ball(1, {0.5, 0.05, 0}, 0.05, 0.2);
  description.velocity_m_s = {-8, 0, 0};
  ASSERT_TRUE(world.add_ball(description));
  double deepest = 1.0;
  for (int i = 0; i < 60; ++i) {
    world.step();
    deepest = std::min(deepest, body_state(world, 1).world_from_body.position_m.x());
  }
  EXPECT_GT(deepest, 0.049);
}

}  // namespace
}  // namespace livegs

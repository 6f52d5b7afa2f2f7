// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/math/rotation_between.h"
#include "prepare/mesh_collider.h"
#include "scenes/rigid_fixtures.h"

// Rays of a hand and the obstacles in front of their target.

namespace livegs {
namespace {

using namespace rigid_fixtures;
using Eigen::Vector3d;

// Boxes of 0.2 m at z = -1 and z = -2, and a collider.
World two_boxes(const Collider& collider) {
  World world = world_at(60, 4, Vector3d::Zero());
  for (uint32_t id : {1u, 2u}) {
    auto box = box_body(id, {0.2, 0.2, 0.2}, 1.0);
    box.world_from_object.position_m = {0, 0, -1.0 * id};
    EXPECT_TRUE(world.add_rigid(box));
  }
  world.add_collider(collider);
  return world;
}

// Orientation of a plane with the given normal.
Eigen::Quaterniond facing(const Vector3d& normal) { return rotation_between(Vector3d::UnitY(), normal); }

uint32_t met(const World& world, const Vector3d& from, const Vector3d& towards) {
  const auto hit = world.ray_cast(from, (towards - from).normalized(), 20.0);
  return hit ? hit->object_id : 0;
}

// A wall of every collider kind between the two boxes.
TEST(WorldRay, WallHidesObjectsBehindIt) {
  const Pose between{{0, 0, -1.5}, Eigen::Quaterniond::Identity()};
  const Collider walls[] = {{BoxShape{{2, 2, 0.02}}, between},
                            {SphereShape{0.3}, between},
                            {mesh_collider(box_mesh({2, 2, 0.02})), between},
                            {wall_collider(box_mesh({2, 2, 0.02})), between},
                            {PlaneShape{}, {between.position_m, facing(Vector3d::UnitZ())}}};
  for (const Collider& wall : walls) {
    SCOPED_TRACE(wall.shape.index());
    const World world = two_boxes(wall);
    EXPECT_EQ(met(world, {0, 0, 0}, {0, 0, -1}), 1u);
    EXPECT_EQ(met(world, {0.5, 0, 0}, {0, 0, -1}), 1u);
    EXPECT_EQ(met(world, {0, 0.25, 0}, {0, 0, -2}), 0u);  // above the first box, blocked by the wall
    EXPECT_EQ(met(world, {0, 3, -2}, {0, 0, -2}), 2u);    // from above, past the wall
  }
}

// A plate slightly sunk into a table is hit from above; from below the table hides it.
TEST(WorldRay, PlateOnTableIsHitOnlyFromAbove) {
  World world = world_at(60, 4, Vector3d::Zero());
  world.add_collider(
      {mesh_collider(box_mesh({1.2, 0.03, 0.8})), {{0, 0.7 - 0.015, 0}, Eigen::Quaterniond::Identity()}});
  auto plate = box_body(1, {0.2, 0.006, 0.2}, 0.1);
  plate.world_from_object.position_m = {0, 0.7, 0};  // the lower half is inside the table
  ASSERT_TRUE(world.add_rigid(plate));
  EXPECT_EQ(met(world, {0, 1.5, 1}, {0, 0.7, 0}), 1u);
  EXPECT_EQ(met(world, {0, 0.9, 2}, {0, 0.703, 0.05}), 1u);
  EXPECT_EQ(met(world, {0, 0.1, 0.3}, {0, 0.7, 0}), 0u);
}

// A camera inside the solid side of a wall, aimed into the room.
TEST(WorldRay, ColliderAroundTheEyeIsIgnored) {
  const Collider wall{PlaneShape{}, {{0, 0, 0.5}, facing(-Vector3d::UnitZ())}};
  World world = two_boxes(wall);  // solid where z > 0.5
  EXPECT_EQ(met(world, {0, 0, 2}, {0, 0, -1}), 1u);
  world.add_collider({BoxShape{{1, 1, 0.1}}, {{0, 0, 0}, Eigen::Quaterniond::Identity()}});
  EXPECT_EQ(met(world, {0, 0, 2}, {0, 0, -1}), 0u);
}

}  // namespace
}  // namespace livegs

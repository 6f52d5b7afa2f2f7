// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "prepare/mesh_collider.h"
#include "scenes/soft_fixtures.h"

// Defects of modelled meshes: open surfaces without volume, and inverted solids.

namespace livegs {
namespace {

using namespace soft_fixtures;

TriangleMesh turned_over(TriangleMesh mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

// A square of 4 m with `parts` by `parts` fields at the heights y(x, z). Triangles do not share vertices.
template <class Height>
TriangleMesh surface(int parts, const Height& height_m) {
  TriangleMesh mesh;
  const auto at = [&](int i, int k) {
    const double x = 4.0 * i / parts - 2.0, z = 4.0 * k / parts - 2.0;
    return Vector3d(x, height_m(x, z), z);
  };
  for (int i = 0; i < parts; ++i) {
    for (int k = 0; k < parts; ++k) {
      for (const auto& corners : {std::array{at(i, k), at(i, k + 1), at(i + 1, k + 1)},
                                  {at(i, k), at(i + 1, k + 1), at(i + 1, k)}}) {
        const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
        mesh.vertices_m.insert(mesh.vertices_m.end(), corners.begin(), corners.end());
        mesh.triangles.push_back({first, first + 1, first + 2});
      }
    }
  }
  return mesh;
}

double hills_m(double x, double z) { return 0.15 * std::sin(2.0 * x) * std::cos(2.0 * z); }

World world_on(const FieldShape& shape, double rate_hz) {
  World world = world_at(rate_hz, 4);
  world.add_collider(Collider{shape, Pose{}, 0.6, 0.0});
  return world;
}

// Places a box, a ball and a soft cube at rest 0.1 m above the surface at `places`. Ids start at 1.
void put_things(World& world, const std::vector<Vector3d>& places_m) {
  for (uint32_t i = 0; i < places_m.size(); ++i) {
    const Vector3d at = places_m[i] + Vector3d(0, 0.15, 0);
    if (i % 3 == 0) {
      auto box = box_body(i + 1, {0.1, 0.1, 0.1}, 0.5);
      box.world_from_object.position_m = at;
      (void)world.add_rigid(box);
    } else if (i % 3 == 1) {
      (void)world.add_ball(ball(i + 1, at));
    } else {
      auto block = soft_block(i + 1, {0.1, 0.1, 0.1}, 0.3, 5e4, 0.025);
      block.world_from_object.position_m = at;
      (void)world.add_elastic(block);
    }
  }
}

TEST(OpenMesh, FloorHoldsObjectsFacingEitherWay) {
  const TriangleMesh floor = surface(1, [](double, double) { return 0.0; });
  for (const double rate_hz : kRates_hz) {
    for (const bool over : {false, true}) {
      SCOPED_TRACE(::testing::Message() << rate_hz << " Hz, " << (over ? "turned over" : "as modelled"));
      World world = world_on(wall_collider(over ? turned_over(floor) : floor), rate_hz);
      put_things(world, {{0, 0, 0}, {0.5, 0, 0.3}, {-0.5, 0, 0.3}});
      run_seconds(world, 2.0);
      for (uint32_t id : {1u, 2u, 3u}) {
        // The wall adds 2 mm; the soft cube is compressed by 0.3 mm.
        EXPECT_NEAR(body_state(world, id).world_from_body.position_m.y(), 0.052, 1e-3) << id;
        EXPECT_TRUE(id == 3 || body_state(world, id).asleep) << id;
      }
    }
  }
}

// Fast objects from above and from below do not pass.
TEST(OpenMesh, FloorBlocksBothSides) {
  const FieldShape floor = wall_collider(surface(1, [](double, double) { return 0.0; }));
  for (const double rate_hz : kRates_hz) {
    for (const double side : {1.0, -1.0}) {
      for (const double speed_m_s : {1.0, 5.0, 20.0, 60.0}) {
        SCOPED_TRACE(::testing::Message() << rate_hz << " Hz, " << side << ", " << speed_m_s << " m/s");
        World world = world_at(rate_hz, 4, Vector3d::Zero());
        world.add_collider(Collider{floor, Pose{}, 0.6, 0.2});
        for (uint32_t id : {1u, 2u}) {
          auto body = id == 1 ? box_body(id, {0.1, 0.1, 0.1}, 0.5) : box_body(id, {0.3, 0.03, 0.03}, 0.2);
          body.world_from_object = {Vector3d(0.6 * id, 0.5 * side, 0.1),
                                    rotation_about(static_cast<int>(id))};
          body.velocity_m_s = {0.1, -side * speed_m_s, 0.2};
          ASSERT_TRUE(world.add_rigid(body));
        }
        auto shot = ball(3, {-0.4, 0.5 * side, 0}, 0.03, 0.1);
        shot.velocity_m_s = {0, -side * speed_m_s, 0};
        ASSERT_TRUE(world.add_ball(shot));
        auto block = soft_block(4, {0.1, 0.1, 0.1}, 0.3, 1e5, 0.025);
        block.world_from_object.position_m = {-1.0, 0.5 * side, 0};
        block.velocity_m_s = {0, -side * std::min(speed_m_s, 20.0), 0};
        ASSERT_TRUE(world.add_elastic(block));
        run_seconds(world, 1.2);
        for (uint32_t id : {1u, 2u, 3u, 4u}) {
          EXPECT_GT(side * body_state(world, id).world_from_body.position_m.y(), 0.0) << id;
        }
      }
    }
  }
}

TEST(OpenMesh, HillsHoldObjectsEverywhere) {
  for (const double rate_hz : kRates_hz) {
    SCOPED_TRACE(rate_hz);
    World world = world_on(wall_collider(surface(40, hills_m)), rate_hz);
    std::vector<Vector3d> places;
    for (const double x : {-1.2, -0.4, 0.4, 1.2}) {
      for (const double z : {-1.2, 0.0, 1.2}) places.push_back({x, hills_m(x, z), z});
    }
    put_things(world, places);
    run_seconds(world, 1.0);
    for (uint32_t id = 1; id <= places.size(); ++id) {
      const Vector3d at = body_state(world, id).world_from_body.position_m;
      const double over_m = at.y() - hills_m(at.x(), at.z());
      EXPECT_GT(over_m, 0.03) << id;  // upright or on a corner, on a slope of at most 17 degrees
      EXPECT_LT(over_m, 0.1) << id;
    }
  }
}

// A table mesh with only a top and a rim that is folded down; it has no bottom.
TEST(OpenMesh, BottomlessTableHoldsObjects) {
  TriangleMesh table = box_mesh({1.2, 0.04, 0.8});
  std::erase_if(table.triangles, [&](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(),
                       [&](uint32_t i) { return table.vertices_m[i].y() < 0.0; });
  });
  World world = world_on(wall_collider(table), 90);
  put_things(world, {{0, 0.02, 0}, {0.3, 0.02, 0.2}, {-0.3, 0.02, -0.2}});
  run_seconds(world, 2.0);
  for (uint32_t id : {1u, 2u, 3u})
    EXPECT_NEAR(body_state(world, id).world_from_body.position_m.y(), 0.072, 1e-3) << id;
}

// Two boards in one mesh, one of them inverted. The boards are thinner than a cell, so the sign comes from
// the triangles.
TEST(OpenMesh, InvertedSolidIsTurnedOver) {
  TriangleMesh mesh;
  for (const double x : {-1.0, 1.0}) {
    TriangleMesh board = box_mesh({1.0, 0.02, 1.0});
    if (x > 0.0) board = turned_over(board);
    const auto first = static_cast<uint32_t>(mesh.vertices_m.size());
    for (const Vector3d& vertex : board.vertices_m) mesh.vertices_m.push_back(vertex + Vector3d(x, 0, 0));
    for (const auto& [a, b, c] : board.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  }
  World world = world_on(mesh_collider(mesh), 60);
  put_things(world, {{-1, 0.01, 0},
                     {-1.3, 0.01, 0.3},
                     {-0.7, 0.01, 0.3},
                     {1, 0.01, 0},
                     {1.3, 0.01, 0.3},
                     {0.7, 0.01, 0.3}});
  run_seconds(world, 2.0);
  for (uint32_t id = 1; id <= 6; ++id)
    EXPECT_NEAR(body_state(world, id).world_from_body.position_m.y(), 0.06, 1e-3) << id;
}

TEST(OpenMesh, HollowStaysHollow) {
  TriangleMesh mesh = box_mesh({1, 1, 1});
  const TriangleMesh inner = turned_over(box_mesh({0.6, 0.6, 0.6}));
  mesh.vertices_m.insert(mesh.vertices_m.end(), inner.vertices_m.begin(), inner.vertices_m.end());
  for (const auto& [a, b, c] : inner.triangles) mesh.triangles.push_back({a + 8, b + 8, c + 8});
  const FieldShape shape = mesh_collider(mesh);
  EXPECT_NEAR(shape.field->sample({0, 0, 0}).distance_m, 0.3, 0.02);
  EXPECT_NEAR(shape.field->sample({0.4, 0, 0}).distance_m, -0.1, 0.02);
  World world = world_on(shape, 60);
  ASSERT_TRUE(world.add_ball(ball(1, {0, 0, 0})));
  run_seconds(world, 1.0);
  EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.y(), -0.25, 1e-3);
}

}  // namespace
}  // namespace livegs

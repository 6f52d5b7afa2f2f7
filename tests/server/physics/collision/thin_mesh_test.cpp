// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "prepare/mesh_collider.h"
#include "scenes/break_fixtures.h"
#include "scenes/soft_fixtures.h"

// Meshes thinner than the cells of their distance field, such as table tops, shelves and fins. No grid node
// lies inside a board thinner than a cell, so the grid alone does not hold objects. 4 substeps.

namespace livegs {
namespace {

using namespace soft_fixtures;

constexpr double kDropped_m = 0.1;

void add(TriangleMesh& all, const TriangleMesh& part, const Vector3d& at_m) {
  const auto start = static_cast<uint32_t>(all.vertices_m.size());
  for (const Vector3d& vertex : part.vertices_m) all.vertices_m.push_back(vertex + at_m);
  for (const auto& [a, b, c] : part.triangles) all.triangles.push_back({a + start, b + start, c + start});
}

// The mesh rotated about the vertical, out of the grid's axes.
TriangleMesh turned(TriangleMesh mesh, double angle_rad) {
  for (Vector3d& vertex : mesh.vertices_m) vertex = Eigen::AngleAxisd(angle_rad, Vector3d::UnitY()) * vertex;
  return mesh;
}

constexpr const char* kThings[] = {"a ball", "a box", "a book", "a cup", "a soft cube"};

// Adds the object and returns the height of its centre above its support, m.
double put(World& world, int thing, uint32_t id, const Vector3d& at_m) {
  switch (thing) {
    case 0:
      (void)world.add_ball(ball(id, at_m, 0.025, 0.1));
      return 0.025;
    case 1:
    case 2: {
      auto body = box_body(id, thing == 1 ? Vector3d(0.1, 0.1, 0.1) : Vector3d(0.2, 0.03, 0.15), 0.5);
      body.world_from_object.position_m = at_m;
      (void)world.add_rigid(body);
      return thing == 1 ? 0.05 : 0.015;
    }
    case 3: {
      auto cup = break_fixtures::cup_at(0.0);
      cup.object_id = id;
      cup.material.fragile = false;
      cup.world_from_object.position_m = at_m;
      (void)world.add_rigid(cup);
      return 0.05;
    }
    default: {
      auto block = soft_block(id, {0.1, 0.1, 0.1}, 0.3, 5e4, 0.02);
      block.world_from_object.position_m = at_m;
      (void)world.add_elastic(block);
      return 0.05;
    }
  }
}

// Places each object on a top at height `top_m` in turn. `make` creates the world with the top.
template <class Make>
void expect_held(double top_m, const Make& make) {
  for (int thing = 0; thing < 5; ++thing) {
    World world = make();
    const double half_m = put(world, thing, 7, {0.11, top_m + kDropped_m, 0.07});
    run_seconds(world, 3.0);
    const double over_m = body_state(world, 7).world_from_body.position_m.y() - top_m;
    // A cup may have tipped over. The soft cube is compressed by its weight: rho g h² / 2 E is 0.3 mm.
    EXPECT_NEAR(over_m, half_m, thing == 3 ? 0.02 : 0.002) << kThings[thing];
  }
}

TEST(ThinMesh, StaticTopsHoldObjects) {
  for (const double rate_hz : kRates_hz) {
    for (const double thick_m : {0.02, 0.03, 0.05}) {
      for (const double angle_rad : {0.0, 0.4}) {
        SCOPED_TRACE(::testing::Message()
                     << thick_m << " m, turned by " << angle_rad << ", " << rate_hz << " Hz");
        TriangleMesh room = box_mesh({4.0, 0.3, 4.0});
        add(room, box_mesh({1.2, thick_m, 0.8}), {0, 0.9 - 0.5 * thick_m, 0});
        const FieldShape shape = mesh_collider(turned(room, angle_rad));
        EXPECT_GT(shape.field->cell_m(), thick_m);
        expect_held(0.9, [&] {
          World world = world_at(rate_hz, 4);
          world.add_collider(Collider{shape, Pose{}, 0.6, 0.0});
          return world;
        });
      }
    }
  }
}

// Boards of 18 mm that extend slightly into the sides, at any offset from the grid nodes.
TEST(ThinMesh, EveryShelfBoardHoldsObjects) {
  constexpr double kBoard_m = 0.018, kShelfHeight_m = 2.0;
  TriangleMesh shelf;
  for (const double x : {-0.4, 0.4})
    add(shelf, box_mesh({kBoard_m, kShelfHeight_m, 0.3}), {x, 0.5 * kShelfHeight_m, 0});
  std::vector<double> tops;
  for (int i = 0; i < 6; ++i) {
    tops.push_back(0.1 + 0.337 * i);
    add(shelf, box_mesh({0.8, kBoard_m, 0.29}), {0, tops.back() - 0.5 * kBoard_m, 0});
  }
  World world = world_at(60, 4);
  world.add_collider(Collider{mesh_collider(shelf), Pose{}, 0.6, 0.0});
  uint32_t id = 1;
  std::vector<double> half_m;
  for (const double top_m : tops) {
    for (int thing = 0; thing < 3; ++thing)
      half_m.push_back(put(world, thing == 0 ? 4 : thing, id++, {0.22 * (thing - 1), top_m + 0.08, 0.0}));
  }
  run_seconds(world, 3.0);
  for (uint32_t i = 0; i < half_m.size(); ++i) {
    const double over_m = body_state(world, i + 1).world_from_body.position_m.y() - tops[i / 3];
    EXPECT_NEAR(over_m, half_m[i], 0.002) << "board " << i / 3 << ", object " << i % 3;
  }
}

TEST(ThinMesh, RigidTableHoldsObjects) {
  constexpr double kTop_m = 0.7;
  for (const double rate_hz : kRates_hz) {
    for (const double thick_m : {0.01, 0.02, 0.03}) {
      SCOPED_TRACE(::testing::Message() << thick_m << " m, " << rate_hz << " Hz");
      TriangleMesh table;
      add(table, box_mesh({1.2, thick_m, 0.7}), {0, kTop_m - 0.5 * thick_m, 0});
      for (const double x : {-0.55, 0.55}) {
        for (const double z : {-0.3, 0.3})
          add(table, box_mesh({0.05, kTop_m - 1e-3 - thick_m, 0.05}),
              {x, 0.5 * (kTop_m - 1e-3 - thick_m), z});
      }
      expect_held(kTop_m, [&] {
        World world = world_at(rate_hz, 4);
        world.add_collider(floor_plane(0.6));
        (void)world.add_rigid(body_of(1, table, 15.0));
        run_seconds(world, 0.2);
        return world;
      });
    }
  }
}

// A board touches the fin between its own contact points, which are 4 cm apart.
TEST(ThinMesh, FinHoldsABoard) {
  for (const double rate_hz : kRates_hz) {
    for (const double wide_m : {0.01, 0.02, 0.03}) {
      for (const double aside_m : {0.0, 0.004, 0.008, 0.012, 0.016}) {
        TriangleMesh mesh = box_mesh({0.64, 0.05, 0.64});
        for (Vector3d& vertex : mesh.vertices_m) vertex.y() -= 0.025;
        add(mesh, box_mesh({wide_m, 0.1 + 0.01, 0.64}), {0, 0.045, 0});
        World world = world_at(rate_hz, 4);
        world.add_collider(Collider{mesh_collider(mesh), Pose{}, 0.6, 0.0});
        auto board = box_body(1, {0.6, 0.03, 0.6}, 2.0);
        board.world_from_object.position_m = {aside_m, 0.1 + 0.015 + 0.002, 0};
        (void)world.add_rigid(board);
        run_seconds(world, 0.25);
        // The board starts to tip once its middle is beyond the fin.
        const double tips_m = aside_m > 0.5 * wide_m ? 0.02 : 0.001;
        EXPECT_NEAR(body_state(world, 1).world_from_body.position_m.y(), 0.115, tips_m)
            << wide_m << " m, " << aside_m << " m aside";
      }
    }
  }
}

// Box-like objects that need continuous collision detection: a fall of 2 m onto a plate of 5 mm.
TEST(ThinMesh, ThinPlateStopsAFallOfTwoMetres) {
  for (const double rate_hz : kRates_hz) {
    const FieldShape shape = mesh_collider(box_mesh({1.2, 0.005, 0.7}));
    for (int thing = 0; thing < 5; ++thing) {
      World world = world_at(rate_hz, 4);
      world.add_collider(Collider{shape, Pose{}, 0.6, 0.0});
      put(world, thing, 7, {0.03, 2.0, 0.02});
      run_seconds(world, 1.0);
      EXPECT_GT(body_state(world, 7).world_from_body.position_m.y(), 0.0)
          << kThings[thing] << ", " << rate_hz << " Hz";
    }
  }
}

}  // namespace
}  // namespace livegs

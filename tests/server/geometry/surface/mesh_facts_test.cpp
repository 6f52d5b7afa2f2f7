// SPDX-License-Identifier: Apache-2.0
#include "geometry/surface/mesh_facts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

#include "core/parallel_for.h"
#include "geometry/mesh/convex_hull.h"
#include "geometry/surface/shape_mesh.h"
#include "server/geometry/mesh/mesh_checks.h"
#include "server/geometry/surface/point_clouds.h"

namespace livegs {
namespace {

using std::numbers::pi;

// A cup without a handle: a cylinder with a deep bore from the top.
TriangleMesh cup(double radius_m, double height_m, double wall_m) {
  // Outer and inner side, joined at the rim. The profile runs from the outer foot to the inner bottom.
  const double profile[][2] = {
      {radius_m, 0.0}, {radius_m, height_m}, {radius_m - wall_m, height_m}, {radius_m - wall_m, wall_m}};
  TriangleMesh mesh;
  constexpr uint32_t kAround = 32;
  for (const auto& [r, y] : profile) {
    for (uint32_t s = 0; s < kAround; ++s) {
      const double turn = 2 * pi * s / kAround;
      mesh.vertices_m.emplace_back(r * std::cos(turn), y, -r * std::sin(turn));
    }
  }
  mesh.vertices_m.emplace_back(0, 0, 0);
  mesh.vertices_m.emplace_back(0, wall_m, 0);
  const uint32_t foot = 4 * kAround, bottom = foot + 1;
  for (uint32_t s = 0; s < kAround; ++s) {
    const uint32_t n = (s + 1) % kAround;
    for (uint32_t ring = 0; ring < 3; ++ring) {
      const uint32_t a = ring * kAround, b = a + kAround;
      mesh.triangles.push_back({a + s, a + n, b + n});
      mesh.triangles.push_back({a + s, b + n, b + s});
    }
    mesh.triangles.push_back({foot, n, s});
    mesh.triangles.push_back({bottom, 3 * kAround + s, 3 * kAround + n});
  }
  return mesh;
}

// Independent of orientation: the smallest box of a brick is the brick, that of a ball is its bounding cube.
TEST(MeshFacts, SmallestBoxRotatesWithTheBody) {
  TriangleMesh brick = box_mesh({0.4, 0.1, 0.2});
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()));
  for (Eigen::Vector3d& vertex : brick.vertices_m) vertex = turn * vertex;
  const MeshFacts facts = mesh_facts(brick);
  EXPECT_TRUE(facts.box_m.isApprox(Eigen::Vector3d(0.4, 0.2, 0.1), 1e-9)) << facts.box_m.transpose();
  EXPECT_GT(facts.size_m.prod(), 1.5 * facts.box_m.prod());
  EXPECT_TRUE(mesh_facts(sphere_mesh(0.1, 3)).box_m.isApprox(Eigen::Vector3d::Constant(0.2), 0.01));
}

TEST(MeshFacts, BrickMatchesItsDimensions) {
  const MeshFacts facts = mesh_facts(box_mesh({0.4, 0.1, 0.2}));
  EXPECT_TRUE(facts.size_m.isApprox(Eigen::Vector3d(0.4, 0.1, 0.2)));
  EXPECT_TRUE(facts.principal_size_m.isApprox(Eigen::Vector3d(0.4, 0.2, 0.1), 1e-9));
  EXPECT_NEAR(facts.volume_m3, 0.008, 1e-15);
  EXPECT_NEAR(facts.mean_wall_m, 2 * 0.008 / 0.28, 1e-12);
  EXPECT_NEAR(facts.hull_volume_m3, 0.008, 1e-15);
  EXPECT_NEAR(facts.solidity, 1.0, 1e-12);
  EXPECT_EQ(facts.openness, 0.0);
  EXPECT_EQ(facts.piece_count, 1);
  EXPECT_EQ(facts.thin_sheet, 0.0);
  EXPECT_EQ(facts.rod, 0.0);
}

TEST(MeshFacts, SheetsAndRods) {
  EXPECT_EQ(mesh_facts(sphere_mesh(0.1, 3)).thin_sheet, 0.0);
  EXPECT_EQ(mesh_facts(box_mesh({1, 1, 1})).thin_sheet, 0.0);
  EXPECT_EQ(mesh_facts(box_mesh({0.3, 0.002, 0.2})).thin_sheet, 1.0);
  EXPECT_EQ(mesh_facts(box_mesh({0.3, 0.002, 0.2})).rod, 0.0);
  EXPECT_EQ(mesh_facts(cylinder_mesh(0.01, 0.5)).rod, 1.0);
  EXPECT_EQ(mesh_facts(cylinder_mesh(0.01, 0.5)).thin_sheet, 0.0);
}

TEST(MeshFacts, CupIsOpenButBallAndTableAreNot) {
  TriangleMesh mesh = cup(0.04, 0.1, 0.004);
  testing::expect_body(mesh);
  const MeshFacts facts = mesh_facts(mesh);
  // Only the cavity below the mouth of the cup counts; it is 0.8 of the total volume.
  EXPECT_GT(facts.openness, 0.6);
  EXPECT_LT(facts.openness, 0.85);
  EXPECT_LT(facts.solidity, 0.3);
  EXPECT_GT(facts.thin_sheet, 0.3);
  EXPECT_EQ(mesh_facts(sphere_mesh(0.1, 3)).openness, 0.0);
  TriangleMesh table = box_mesh({1.0, 0.04, 0.8});
  for (double x : {-0.45, 0.45}) {
    for (double z : {-0.35, 0.35}) {
      table = testing::joined(table, testing::moved(box_mesh({0.05, 0.7, 0.05}), {x, -0.36, z}));
    }
  }
  EXPECT_LT(mesh_facts(table).openness, 0.1);
}

TEST(MeshFacts, AreEqualForAnyThreadCount) {
  const TriangleMesh mesh = cup(0.04, 0.1, 0.004);
  set_thread_count(1);
  const double one = mesh_facts(mesh).openness;
  set_thread_count(4);
  EXPECT_EQ(mesh_facts(mesh).openness, one);
  set_thread_count(0);
}

TEST(ConvexHull, IgnoresPointsInsideACube) {
  testing::Points points = testing::cloud(500, 1, [](testing::Random& r) { return r.in_cube(); });
  for (int corner = 0; corner < 8; ++corner) {
    points.emplace_back(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
  }
  const TriangleMesh hull = convex_hull(points);
  testing::expect_body(hull);
  EXPECT_EQ(hull.vertices_m.size(), 8u);
  EXPECT_NEAR(signed_volume_m3(hull), 8.0, 1e-12);
  EXPECT_TRUE(
      convex_hull(testing::Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {3, 2, 0}}).triangles.empty());
  EXPECT_TRUE(convex_hull(testing::Points{{0, 0, 0}, {1, 0, 0}}).triangles.empty());
  EXPECT_TRUE(convex_hull(testing::Points(9, Eigen::Vector3d::Zero())).triangles.empty());
  EXPECT_TRUE(convex_hull(testing::Points{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}).triangles.empty());
}

}  // namespace
}  // namespace livegs

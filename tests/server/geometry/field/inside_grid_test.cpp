// SPDX-License-Identifier: Apache-2.0
#include "geometry/field/inside_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "geometry/surface/shape_mesh.h"
#include "server/geometry/mesh/mesh_checks.h"
#include "server/geometry/surface/point_clouds.h"

namespace livegs {
namespace {

using testing::joined;
using testing::moved;

RegularGrid grid_over(double half_m, int count) {
  RegularGrid grid;
  grid.origin_m = Eigen::Vector3d::Constant(-half_m);
  grid.cell_m = 2 * half_m / (count - 1);
  grid.counts = Eigen::Vector3i::Constant(count);
  return grid;
}

size_t inside_count(const TriangleMesh& mesh, const RegularGrid& grid) {
  const auto inside = nodes_inside(mesh, grid);
  return std::accumulate(inside.begin(), inside.end(), size_t{0});
}

TEST(InsideGrid, LinesThroughEdgesAndVerticesDoNotLeak) {
  // Nodes lie exactly on faces, edges, diagonals and corners of the cube, and on vertices and edges of the
  // sphere.
  const RegularGrid grid = grid_over(1.0, 21);
  const auto cube = nodes_inside(box_mesh({1, 1, 1}), grid);
  const auto ball = nodes_inside(sphere_mesh(0.75, 2), grid);
  for (int k = 0; k < 21; ++k) {
    for (int j = 0; j < 21; ++j) {
      for (int i = 0; i < 21; ++i) {
        const Eigen::Vector3d p = grid.point_m(i, j, k);
        const double reach = p.cwiseAbs().maxCoeff();
        if (reach < 0.49) {
          EXPECT_TRUE(cube[grid.index(i, j, k)]) << p.transpose();
        }
        if (reach > 0.51) {
          EXPECT_FALSE(cube[grid.index(i, j, k)]) << p.transpose();
        }
        // The faces of the icosphere are at least 0.96 of its radius from the centre.
        if (p.norm() < 0.71) {
          EXPECT_TRUE(ball[grid.index(i, j, k)]) << p.transpose();
        }
        if (p.norm() > 0.751) {
          EXPECT_FALSE(ball[grid.index(i, j, k)]) << p.transpose();
        }
      }
    }
  }
}

TEST(InsideGrid, CountsTheVolumeOfARotatedBox) {
  TriangleMesh mesh = box_mesh({1.0, 0.6, 0.3});
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(3, 1, 2).normalized()).toRotationMatrix();
  for (auto& vertex : mesh.vertices_m) vertex = turn * vertex;
  const RegularGrid grid = grid_over(0.7, 101);
  const double counted = static_cast<double>(inside_count(mesh, grid)) * std::pow(grid.cell_m, 3);
  // Each cell on the surface has a random error of half its volume; with 11 000 cells, a bar of 1 % is
  // generous.
  EXPECT_NEAR(counted / 0.18, 1.0, 0.01);
}

TEST(InsideGrid, OverlapsCountOnceAndCavitiesDoNot) {
  const RegularGrid grid = grid_over(1.0, 41);
  const TriangleMesh a = box_mesh({0.93, 0.93, 0.93});
  const TriangleMesh overlapping = joined(a, moved(a, {0.31, 0, 0}));
  TriangleMesh hollow = box_mesh({0.51, 0.51, 0.51});
  for (auto& triangle : hollow.triangles) std::swap(triangle[1], triangle[2]);
  // A size of 0.93 contains nodes -0.45 to 0.45: 19 per axis; shifted by 0.31: -0.15 to 0.75. A size of 0.51
  // contains 11.
  EXPECT_EQ(inside_count(a, grid), 19u * 19u * 19u);
  EXPECT_EQ(inside_count(overlapping, grid), 25u * 19u * 19u);
  EXPECT_EQ(inside_count(joined(a, hollow), grid), 19u * 19u * 19u - 11u * 11u * 11u);
}

TEST(InsideGrid, SliversAndFoldsCauseNoScanlineErrors) {
  // A closed surface of random, partly degenerate triangles: points beyond all of them are outside.
  testing::Random random(11);
  TriangleMesh mesh = sphere_mesh(0.5, 3);
  for (auto& vertex : mesh.vertices_m) {
    vertex += 0.2 * random.in_cube();
    if (random.uniform() < 0.3) vertex = (vertex * 20).array().round().matrix() / 20;  // onto grid nodes
  }
  RegularGrid grid = grid_over(1.0, 41);
  const auto inside = nodes_inside(mesh, grid);
  const Eigen::AlignedBox3d bounds = mesh_bounds_m(mesh);
  for (int k = 0; k < 41; ++k) {
    for (int j = 0; j < 41; ++j) {
      for (int i = 0; i < 41; ++i) {
        const Eigen::Vector3d p = grid.point_m(i, j, k);
        if (bounds.exteriorDistance(p) > 1e-9) {
          EXPECT_FALSE(inside[grid.index(i, j, k)]) << p.transpose();
        }
      }
    }
  }
}

}  // namespace
}  // namespace livegs

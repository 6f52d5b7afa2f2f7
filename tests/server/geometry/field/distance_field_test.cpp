// SPDX-License-Identifier: Apache-2.0
#include "geometry/field/distance_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "geometry/mesh/triangle_distance.h"
#include "geometry/surface/shape_mesh.h"
#include "server/geometry/mesh/mesh_checks.h"
#include "server/geometry/surface/point_clouds.h"

namespace livegs {
namespace {

double box_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& half) {
  const Eigen::Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

double nearest_of_all_triangles(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double best2 = std::numeric_limits<double>::max();
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d q =
        closest_point_on_triangle(p, mesh.vertices_m[a], mesh.vertices_m[b], mesh.vertices_m[c]);
    best2 = std::min(best2, (q - p).squaredNorm());
  }
  return std::sqrt(best2);
}

TEST(DistanceField, BoxIsExactAtItsNodes) {
  const Eigen::Vector3d half(0.2, 0.05, 0.1);
  const DistanceField field(box_mesh(2 * half), 0.02, 0.1);
  for (int k = 0; k < field.node_counts().z(); ++k) {
    for (int j = 0; j < field.node_counts().y(); ++j) {
      for (int i = 0; i < field.node_counts().x(); ++i) {
        const Eigen::Vector3d p = -half - Eigen::Vector3d::Constant(0.1) + 0.02 * Eigen::Vector3d(i, j, k);
        // Distances are stored as floats.
        EXPECT_NEAR(field.sample(p).distance_m, box_distance(p, half), 1e-7) << p.transpose();
      }
    }
  }
}

TEST(DistanceField, BoxErrorBetweenNodesIsBounded) {
  const Eigen::Vector3d half(0.2, 0.05, 0.1);
  const double cell_m = 0.01;
  const DistanceField field(box_mesh(2 * half), cell_m, 0.05);
  testing::Random random(3);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p = random.in_cube().cwiseProduct(half + Eigen::Vector3d::Constant(0.05));
    worst = std::max(worst, std::abs(field.sample(p).distance_m - box_distance(p, half)));
  }
  // Where three faces are equally near, the distance is min(x, y, z). Seven corners of a cell have 0 and one
  // has 1, so trilinear interpolation gives 1/8 in the middle in place of 1/2. Where two faces are equally
  // near, the error is a quarter.
  EXPECT_LT(worst, 0.375 * cell_m);
}

TEST(DistanceField, SphereErrorIsASmallPartOfACell) {
  const double radius = 0.5, cell_m = 0.02;
  const TriangleMesh mesh = sphere_mesh(radius, 5);
  const DistanceField field(mesh, cell_m, 0.2);
  // The mesh lies up to 1.3e-4 inside the sphere (sagitta of edges of 0.02). The trilinear error is at most
  // cell²/8 times the sum of the curvatures, 2/r: 2e-4 at the surface, 4e-4 at r = 0.25. Propagated distances
  // may be off by a tenth of a cell.
  testing::Random random(4);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d way = random.direction();
    const double r = random.uniform(0.25, 0.7);
    const auto sample = field.sample(r * way);
    const bool in_band = std::abs(r - radius) < 0.2 * cell_m;  // all surrounding nodes are exact
    EXPECT_NEAR(sample.distance_m, r - radius, in_band ? 3.5e-4 : 5e-4 + 0.1 * cell_m);
    EXPECT_NEAR(sample.gradient.norm(), 1.0, 1e-12);
    // The gradient error is the second derivative of the distance times the cell.
    EXPECT_GT(sample.gradient.dot(way), 0.99);
  }
}

TEST(DistanceField, PropagatedDistancesAreNearlyExact) {
  // A bumpy body with far more triangles than cells.
  TriangleMesh mesh = sphere_mesh(0.5, 4);
  for (auto& v : mesh.vertices_m) v *= 1.0 + 0.2 * std::sin(9 * v.x()) * std::cos(7 * v.y() + 5 * v.z());
  const double cell_m = 0.06;
  const DistanceField field(mesh, cell_m, 0.3);
  const Eigen::Vector3d origin = mesh_bounds_m(mesh).min().array() - 0.3;
  double worst = 0.0;
  for (int k = 0; k < field.node_counts().z(); k += 2) {
    for (int j = 0; j < field.node_counts().y(); j += 2) {
      for (int i = 0; i < field.node_counts().x(); i += 2) {
        const Eigen::Vector3d p = origin + cell_m * Eigen::Vector3d(i, j, k);
        const double exact = nearest_of_all_triangles(mesh, p);
        const double got = std::abs(field.sample(p).distance_m);
        EXPECT_GT(got, exact - 1e-6);
        if (exact <= cell_m) {
          EXPECT_NEAR(got, exact, 1e-6);
        }
        worst = std::max(worst, got - exact);
      }
    }
  }
  std::printf("propagated distances: at most %.3f of a cell too large\n", worst / cell_m);
  EXPECT_LT(worst, 0.1 * cell_m);
}

TEST(DistanceField, OutsideTheGridIsNeverFarTooSmall) {
  const double cell_m = 0.02;
  const DistanceField field(box_mesh({0.4, 0.1, 0.2}), cell_m, 0.04);
  testing::Random random(5);
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d p = 3.0 * random.in_cube();
    const double exact = box_distance(p, {0.2, 0.05, 0.1});
    if (exact < 0.1) continue;
    const auto sample = field.sample(p);
    EXPECT_GT(sample.distance_m, exact - cell_m);
    EXPECT_GT(sample.gradient.dot(p.normalized()), 0.0);
  }
}

TEST(DistanceField, EnlargesATinyCell) {
  const DistanceField field(box_mesh({1, 1, 1}), 1e-9, 0.1);
  EXPECT_GT(field.cell_m(), 1e-3);
  EXPECT_NEAR(field.sample({0, 0.55, 0}).distance_m, 0.05, 1e-6);
}

// Boards from a tenth of a cell to two and a half cells, at random positions in the grid. The sign is correct
// on both sides of a face. The distance is exact, or as accurate as the grid for thick walls.
TEST(DistanceField, ThinBoardsAreExact) {
  testing::Random random(6);
  for (const double thick : {0.1, 0.3, 0.8, 1.2, 1.6, 2.0, 2.5}) {
    const double cell_m = 1.2 / 64;
    const Eigen::Vector3d half(0.6, 0.5 * thick * cell_m, 0.35);
    for (int at = 0; at < 5; ++at) {
      TriangleMesh board = box_mesh(2 * half);
      // A small part below shifts the nodes relative to the board.
      for (const Eigen::Vector3d& corner : box_mesh({0.01, 0.01, 0.01}).vertices_m)
        board.vertices_m.push_back(corner);
      const auto start = static_cast<uint32_t>(board.vertices_m.size() - 8);
      for (size_t i = start; i < board.vertices_m.size(); ++i)
        board.vertices_m[i].y() -= 0.2 + 0.2 * at * cell_m;
      for (const auto& [a, b, c] : box_mesh({0.01, 0.01, 0.01}).triangles)
        board.triangles.push_back({a + start, b + start, c + start});
      const DistanceField field(board, cell_m, 2 * cell_m, DistanceField::Thin::Exact);
      EXPECT_LE(field.thinnest_m(), std::max(thick * cell_m, 0.01) + 1e-9);
      double worst = 0.0;
      for (int i = 0; i < 2000; ++i) {
        // Thin boards are tested everywhere; thick ones near a face but not at its rim, where a grid rounds.
        Eigen::Vector3d p = random.in_cube().cwiseProduct(half + Eigen::Vector3d::Constant(0.2 * cell_m));
        if (thick > 0.5) {
          p = p.cwiseProduct(Eigen::Vector3d(0.8, 0.0, 0.8));
          p.y() = random.uniform(-0.2, 0.2) * cell_m + (i % 2 == 0 ? half.y() : -half.y());
        }
        worst = std::max(worst, std::abs(field.sample(p).distance_m - box_distance(p, half)));
      }
      EXPECT_LT(worst, 1e-6 * cell_m + (thick > 1.0 ? 0.02 * cell_m : 0.0))
          << thick << " cells, position " << at;
    }
  }
}

// A query with NaN or infinity reads nothing outside the grid.
TEST(DistanceField, IsNanAtNan) {
  const DistanceField field(box_mesh({1, 1, 1}), 0.1, 0.1);
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(field.sample({nan, 0.2, 0.3}).distance_m));
  EXPECT_TRUE(std::isnan(field.sample({0.1, 0.2, nan}).distance_m));
  EXPECT_FALSE(std::isfinite(field.sample({infinity, 0, 0}).distance_m));
  EXPECT_FALSE(std::isfinite(field.sample({0, -infinity, 0}).distance_m));
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/mesh_collider.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "geometry/mesh_topology.h"
#include "geometry/weld_vertices.h"

namespace livegs {
namespace {

constexpr double kFieldCells = 64.0;
constexpr double kRidgeCells = 0.5;
constexpr size_t kMostRidgePoints = 32768;
constexpr double kSmooth = 0.866;  // cosine of 30 degrees

struct Corner {
  Eigen::Vector3d normal;  // of the triangle, not a unit
  uint32_t opposite;
};

}  // namespace

RidgePoints ridge_points(const TriangleMesh& mesh, double spacing_m) {
  const TriangleMesh welded = weld_vertices(mesh);
  const auto& at = welded.vertices_m;
  std::map<std::pair<uint32_t, uint32_t>, Corner> sides;  // by directed edge
  for (const auto& [a, b, c] : welded.triangles) {
    const Eigen::Vector3d normal = (at[b] - at[a]).cross(at[c] - at[a]);
    sides[{a, b}] = {normal, c};
    sides[{b, c}] = {normal, a};
    sides[{c, a}] = {normal, b};
  }
  RidgePoints ridges;
  std::vector<uint8_t> is_corner(at.size(), 0);
  for (const auto& [edge, one] : sides) {
    const auto [a, b] = edge;
    if (const auto other = sides.find({b, a}); other != sides.end()) {
      if (a > b) continue;
      const Eigen::Vector3d& normal = other->second.normal;
      if (one.normal.dot(normal) > kSmooth * one.normal.norm() * normal.norm()) continue;
      if (one.normal.dot(at[other->second.opposite] - at[a]) >= 0.0) continue;  // it is a groove
    }
    is_corner[a] = is_corner[b] = 1;
    const int parts = static_cast<int>(std::ceil((at[b] - at[a]).norm() / spacing_m));
    for (int i = 1; i < parts; ++i) ridges.points_m.push_back(at[a] + static_cast<double>(i) / parts * (at[b] - at[a]));
  }
  for (size_t i = 0; i < at.size(); ++i) {
    if (is_corner[i]) ridges.points_m.push_back(at[i]);
  }
  ridges.tree = PointTree(ridges.points_m);
  return ridges;
}

FieldShape mesh_collider(const TriangleMesh& mesh) {
  const double cell_m = mesh_bounds_m(mesh).sizes().maxCoeff() / kFieldCells;
  FieldShape shape;
  shape.field = std::make_shared<const DistanceField>(mesh, cell_m, 2.0 * cell_m, DistanceField::Thin::Exact);
  RidgePoints ridges;
  double spacing_m = kRidgeCells * cell_m;
  do {
    ridges = ridge_points(mesh, spacing_m);
    spacing_m *= 2.0;
  } while (ridges.points_m.size() > kMostRidgePoints && spacing_m < kFieldCells * cell_m);
  shape.ridges = std::make_shared<const RidgePoints>(std::move(ridges));
  return shape;
}

}  // namespace livegs

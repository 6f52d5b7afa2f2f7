// SPDX-License-Identifier: GPL-3.0-or-later
// Solid angle: Van Oosterom and Strackee 1983, The solid angle of a plane triangle. It is 4 pi inside a
// closed mesh.
#include "prepare/mesh_collider.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "geometry/mesh/mesh_topology.h"
#include "geometry/mesh/weld_vertices.h"
#include "physics/collision/contact_candidate.h"

namespace livegs {
namespace {

// Cells of the distance field along the longest side. Larger: finer features, memory grows with the cube.
constexpr double kFieldCells = 64.0;
constexpr double kWallThickness_m = 0.004;  // see wall_thickness_m

struct Corner {
  Eigen::Vector3d normal;  // of the triangle, not normalised
  uint32_t opposite;
};

struct Part {
  std::vector<uint32_t> triangles;
  double volume_m3 = 0.0;
};

double solid_angle(const TriangleMesh& mesh, const Part& part, const Eigen::Vector3d& from_m) {
  double sum = 0.0;
  for (const uint32_t t : part.triangles) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Eigen::Vector3d a = mesh.vertices_m[i] - from_m, b = mesh.vertices_m[j] - from_m,
                          c = mesh.vertices_m[k] - from_m;
    const double p = a.norm(), q = b.norm(), r = c.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), p * q * r + a.dot(b) * r + b.dot(c) * p + c.dot(a) * q);
  }
  return sum;
}

// Orients every closed part outwards, except inward-facing parts inside another part, which are cavities.
TriangleMesh turned_out(TriangleMesh mesh) {
  const std::vector<int> part_of = mesh_pieces(mesh);
  std::vector<Part> parts;
  for (uint32_t t = 0; t < part_of.size(); ++t) {
    const auto number = static_cast<size_t>(part_of[t]);
    if (number >= parts.size()) parts.resize(number + 1);
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3d& origin = mesh.vertices_m[mesh.triangles[0][0]];
    parts[number].triangles.push_back(t);
    parts[number].volume_m3 +=
        (mesh.vertices_m[a] - origin).dot((mesh.vertices_m[b] - origin).cross(mesh.vertices_m[c] - origin)) /
        6.0;
  }
  for (const Part& part : parts) {
    if (part.volume_m3 >= 0.0) continue;
    const Eigen::Vector3d& place = mesh.vertices_m[mesh.triangles[part.triangles[0]][0]];
    const bool hollow = std::any_of(parts.begin(), parts.end(), [&](const Part& other) {
      return other.volume_m3 > 0.0 && solid_angle(mesh, other, place) > 2.0 * std::numbers::pi;
    });
    if (hollow) continue;
    for (const uint32_t t : part.triangles) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
  return mesh;
}

// Adds the reverse of each triangle, so that there is no inside.
TriangleMesh both_ways(const TriangleMesh& mesh) {
  TriangleMesh both = mesh;
  for (const auto& [a, b, c] : mesh.triangles) both.triangles.push_back({a, c, b});
  return both;
}

// Samples edges with a dihedral angle of more than 30 degrees and boundary edges, at most `spacing_m` apart.
// Concave edges are included for open surfaces, where the other side sees them as ridges.
enum class ConcaveEdges { Skip, Include };
RidgePoints ridge_points(const TriangleMesh& mesh, double spacing_m, ConcaveEdges concave_edges) {
  const TriangleMesh welded = weld_vertices(mesh);
  const auto& at = welded.vertices_m;
  std::map<std::pair<uint32_t, uint32_t>, Corner> sides;  // key: directed edge
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
      if (one.normal.dot(normal) > kSameDirectionCosine * one.normal.norm() * normal.norm()) continue;
      const bool groove = one.normal.dot(at[other->second.opposite] - at[a]) >= 0.0;
      if (groove && concave_edges == ConcaveEdges::Skip) continue;
    }
    is_corner[a] = is_corner[b] = 1;
    const int parts = static_cast<int>(std::ceil((at[b] - at[a]).norm() / spacing_m));
    for (int i = 1; i < parts; ++i)
      ridges.points_m.push_back(at[a] + static_cast<double>(i) / parts * (at[b] - at[a]));
  }
  for (size_t i = 0; i < at.size(); ++i) {
    if (is_corner[i]) ridges.points_m.push_back(at[i]);
  }
  ridges.tree = BoundingSphereTree(ridges.points_m);
  return ridges;
}

RidgePoints affordable_ridges(const TriangleMesh& mesh, double cell_m, ConcaveEdges concave_edges) {
  RidgePoints ridges;
  double spacing_m = 0.5 * cell_m;
  do {
    ridges = ridge_points(mesh, spacing_m, concave_edges);
    spacing_m *= 2.0;
  } while (ridges.points_m.size() > 32768 /* for memory */ && spacing_m < kFieldCells * cell_m);
  return ridges;
}

}  // namespace

FieldShape mesh_collider(const TriangleMesh& mesh) {
  const TriangleMesh solid = turned_out(weld_vertices(mesh));
  const double cell_m = mesh_bounds_m(solid).sizes().maxCoeff() / kFieldCells;
  FieldShape shape;
  shape.field =
      std::make_shared<const DistanceField>(solid, cell_m, 2.0 * cell_m, DistanceField::Thin::Exact);
  shape.ridges = std::make_shared<const RidgePoints>(affordable_ridges(solid, cell_m, ConcaveEdges::Skip));
  return shape;
}

FieldShape wall_collider(const TriangleMesh& mesh) {
  const TriangleMesh surface = weld_vertices(mesh);
  const double cell_m = mesh_bounds_m(surface).sizes().maxCoeff() / kFieldCells;
  FieldShape shape;
  shape.field = std::make_shared<const DistanceField>(both_ways(surface), cell_m, 2.0 * cell_m);
  shape.ridges =
      std::make_shared<const RidgePoints>(affordable_ridges(surface, cell_m, ConcaveEdges::Include));
  shape.sheet = std::make_shared<const TriangleTree>(surface);
  shape.half_thickness_m = 0.5 * wall_thickness_m(kFieldCells * cell_m);
  return shape;
}

double wall_thickness_m(double longest_m) { return std::min(kWallThickness_m, longest_m / kFieldCells); }

}  // namespace livegs

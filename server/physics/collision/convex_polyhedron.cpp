// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/convex_polyhedron.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <numeric>
#include <utility>

#include "core/assert.h"
#include "geometry/surface/shape_mesh.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kPlaneTolerance = 1e-5;  // relative to the size: vertices closer to a plane lie in it

struct Welded {
  std::vector<Vector3d> vertices;
  std::vector<std::array<uint16_t, 3>> triangles;
};

// Merges coincident vertices and removes degenerate triangles.
std::optional<Welded> weld(const TriangleMesh& mesh) {
  if (mesh.vertices_m.size() > 4 * kMaxPolyhedronVertices) return std::nullopt;
  Welded welded;
  std::vector<uint16_t> index_of(mesh.vertices_m.size());
  for (size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    size_t found = 0;
    while (found < welded.vertices.size() && welded.vertices[found] != mesh.vertices_m[i]) ++found;
    if (found == welded.vertices.size()) welded.vertices.push_back(mesh.vertices_m[i]);
    index_of[i] = static_cast<uint16_t>(found);
  }
  if (welded.vertices.size() > kMaxPolyhedronVertices) return std::nullopt;
  for (const auto& t : mesh.triangles) {
    const std::array<uint16_t, 3> corner{index_of[t[0]], index_of[t[1]], index_of[t[2]]};
    if (corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0])
      welded.triangles.push_back(corner);
  }
  return welded;
}

Vector3d area_of(const Welded& mesh, size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
}

using DirectedEdges = std::map<std::pair<uint16_t, uint16_t>, size_t>;  // value: the triangle on the left

// Boundary of a set of triangles as one loop; empty if it is not a single loop.
std::vector<uint16_t> boundary_loop(const Welded& mesh, const std::vector<size_t>& region) {
  std::map<uint16_t, uint16_t> next;
  std::map<std::pair<uint16_t, uint16_t>, int> count;
  for (const size_t t : region) {
    for (int k = 0; k < 3; ++k) ++count[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}];
  }
  for (const auto& [edge, times] : count) {
    if (times != 1) return {};
    if (count.contains({edge.second, edge.first})) continue;
    if (!next.emplace(edge.first, edge.second).second) return {};
  }
  std::vector<uint16_t> loop;
  if (next.empty()) return loop;
  for (uint16_t at = next.begin()->first; loop.size() < next.size(); at = next.at(at)) {
    loop.push_back(at);
    if (!next.contains(at)) return {};
  }
  return next.at(loop.back()) == loop.front() ? loop : std::vector<uint16_t>{};
}

bool add_edges(ConvexPolyhedron& hull) {
  std::map<std::pair<uint16_t, uint16_t>, uint16_t> left_of;
  for (size_t f = 0; f < hull.faces.size(); ++f) {
    const auto& face = hull.faces[f];
    for (int k = 0; k < face.count; ++k) {
      const uint16_t from = hull.loops[face.first + k], to = hull.loops[face.first + (k + 1) % face.count];
      if (!left_of.emplace(std::pair(from, to), static_cast<uint16_t>(f)).second) return false;
    }
  }
  for (const auto& [edge, left] : left_of) {
    const auto back = left_of.find({edge.second, edge.first});
    if (back == left_of.end()) return false;
    if (edge.first < edge.second) hull.edges.push_back({edge.first, edge.second, left, back->second});
  }
  return true;
}

}  // namespace

std::optional<ConvexPolyhedron> convex_polyhedron(const TriangleMesh& mesh) {
  const auto welded = weld(mesh);
  if (!welded || welded->triangles.size() < 4) return std::nullopt;
  Eigen::AlignedBox3d bounds;
  for (const Vector3d& vertex : welded->vertices) bounds.extend(vertex);
  const double size = bounds.diagonal().norm(), tolerance = kPlaneTolerance * size;
  const size_t count = welded->triangles.size();
  DirectedEdges edges;
  for (size_t t = 0; t < count; ++t) {
    const auto& corner = welded->triangles[t];
    for (int k = 0; k < 3; ++k) {
      if (!edges.emplace(std::pair(corner[k], corner[(k + 1) % 3]), t).second) return std::nullopt;
    }
  }

  // Faces grow from the largest triangles, whose planes are the most accurate.
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, std::greater(),
                           [&](size_t t) { return area_of(*welded, t).squaredNorm(); });
  ConvexPolyhedron hull;
  std::vector<char> taken(count, 0);
  for (const size_t seed : order) {
    if (taken[seed]) continue;
    const Vector3d area = area_of(*welded, seed);
    if (!(area.norm() > 0.0)) return std::nullopt;
    const Vector3d normal = area.normalized();
    const double offset = normal.dot(welded->vertices[welded->triangles[seed][0]]);
    const auto height = [&](uint16_t v) { return normal.dot(welded->vertices[v]) - offset; };
    for (size_t v = 0; v < welded->vertices.size(); ++v) {
      if (height(static_cast<uint16_t>(v)) > tolerance) return std::nullopt;
    }
    std::vector<size_t> region{seed};
    taken[seed] = 1;
    for (size_t i = 0; i < region.size(); ++i) {
      const auto& corner = welded->triangles[region[i]];
      for (int k = 0; k < 3; ++k) {
        const auto neighbour = edges.find({corner[(k + 1) % 3], corner[k]});
        if (neighbour == edges.end()) return std::nullopt;
        const auto& other = welded->triangles[neighbour->second];
        if (taken[neighbour->second] || height(other[0]) < -tolerance || height(other[1]) < -tolerance ||
            height(other[2]) < -tolerance) {
          continue;
        }
        taken[neighbour->second] = 1;
        region.push_back(neighbour->second);
      }
    }
    const std::vector<uint16_t> loop = boundary_loop(*welded, region);
    if (loop.size() < 3 || hull.faces.size() == kMaxPolyhedronFaces) return std::nullopt;
    hull.faces.push_back(
        {normal, offset, static_cast<uint16_t>(hull.loops.size()), static_cast<uint16_t>(loop.size())});
    hull.loops.insert(hull.loops.end(), loop.begin(), loop.end());
  }
  // Removes vertices in the interior of faces and renumbers the others.
  std::vector<uint16_t> kept = hull.loops;
  std::ranges::sort(kept);
  kept.erase(std::ranges::unique(kept).begin(), kept.end());
  for (const uint16_t v : kept) hull.vertices_m.push_back(welded->vertices[v]);
  for (uint16_t& v : hull.loops) v = static_cast<uint16_t>(std::ranges::lower_bound(kept, v) - kept.begin());
  if (!add_edges(hull)) return std::nullopt;
  hull.centre_m.setZero();
  for (const Vector3d& vertex : hull.vertices_m)
    hull.centre_m += vertex / static_cast<double>(hull.vertices_m.size());
  hull.inner_radius_m = size;
  for (const auto& face : hull.faces) {
    hull.inner_radius_m = std::min(hull.inner_radius_m, face.offset_m - face.normal.dot(hull.centre_m));
  }
  if (hull.inner_radius_m <= 0.0) return std::nullopt;
  return hull;
}

ConvexPolyhedron box_polyhedron(const Vector3d& size_m) {
  auto cube = convex_polyhedron(box_mesh(Vector3d::Ones()));
  LIVEGS_ASSERT(cube.has_value());
  for (Vector3d& vertex : cube->vertices_m) vertex = vertex.cwiseProduct(size_m);
  for (auto& face : cube->faces) face.offset_m = face.normal.dot(cube->loop_vertex(face, 0));
  cube->inner_radius_m = 0.5 * size_m.minCoeff();
  return std::move(*cube);
}

ConvexPolyhedron::Sample ConvexPolyhedron::sample(const Vector3d& point_m) const {
  const Face* top = &faces[0];
  double highest = top->normal.dot(point_m) - top->offset_m;
  for (const Face& face : faces) {
    const double height = face.normal.dot(point_m) - face.offset_m;
    if (height > highest) {
      highest = height;
      top = &face;
    }
  }
  if (highest <= 0.0) return {highest, top->normal};
  // The nearest point lies on a face whose plane has the sample on its outer side.
  double nearest2 = -1.0;
  Vector3d nearest = point_m;
  const auto offer = [&](const Vector3d& foot) {
    const double distance2 = (point_m - foot).squaredNorm();
    if (nearest2 >= 0.0 && distance2 >= nearest2) return;
    nearest2 = distance2;
    nearest = foot;
  };
  for (const Face& face : faces) {
    const double height = face.normal.dot(point_m) - face.offset_m;
    if (height <= 0.0 || (nearest2 >= 0.0 && height * height >= nearest2)) continue;
    bool within = true;
    for (int k = 0; k < face.count; ++k) {
      const Vector3d& from = loop_vertex(face, k);
      const Vector3d along = loop_vertex(face, (k + 1) % face.count) - from;
      if (along.cross(point_m - from).dot(face.normal) >= 0.0) continue;
      within = false;
      offer(from + std::clamp(along.dot(point_m - from) / along.squaredNorm(), 0.0, 1.0) * along);
    }
    if (within) offer(point_m - height * face.normal);
  }
  const double distance = std::sqrt(std::max(0.0, nearest2));
  if (distance < 1e-9 * highest + 1e-15) return {highest, top->normal};
  return {distance, (point_m - nearest) / distance};
}

}  // namespace livegs

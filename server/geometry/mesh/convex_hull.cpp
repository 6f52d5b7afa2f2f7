// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/convex_hull.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <numeric>

#include "geometry/mesh/mesh_topology.h"

namespace livegs {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

// Returns whether no four of the points span a volume. Exact.
bool is_flat(const std::vector<Point>& cloud) {
  const auto end = cloud.end();
  if (cloud.empty()) return true;
  const Point& a = cloud.front();
  const auto b = std::find_if(cloud.begin(), end, [&](const Point& p) { return p != a; });
  if (b == end) return true;
  const auto c = std::find_if(b, end, [&](const Point& p) { return !CGAL::collinear(a, *b, p); });
  if (c == end) return true;
  return std::all_of(c, end, [&](const Point& p) { return CGAL::coplanar(a, *b, *c, p); });
}

// CGAL's order of facets depends on memory addresses. Corners sorted by coordinates and triangles sorted by
// corners give the same bits for the same cloud.
void put_in_order(TriangleMesh& mesh) {
  std::vector<uint32_t> order(mesh.vertices_m.size()), place(order.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const auto &p = mesh.vertices_m[a], &q = mesh.vertices_m[b];
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  });
  std::vector<Eigen::Vector3d> vertices;
  for (uint32_t i = 0; i < order.size(); ++i) {
    place[order[i]] = i;
    vertices.push_back(mesh.vertices_m[order[i]]);
  }
  mesh.vertices_m = std::move(vertices);
  for (auto& triangle : mesh.triangles) {
    for (uint32_t& corner : triangle) corner = place[corner];
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
}

}  // namespace

TriangleMesh convex_hull(std::span<const Eigen::Vector3d> points_m) {
  std::vector<Point> cloud;
  cloud.reserve(points_m.size());
  for (const auto& point : points_m) cloud.emplace_back(point.x(), point.y(), point.z());
  // CGAL 5.5 throws for a flat cloud, or returns a polygon with invalid indices.
  if (is_flat(cloud)) return {};
  // Surface_mesh uses exact plane predicates. The overload for plain arrays rounds them, which fails for thin
  // bodies.
  CGAL::Surface_mesh<Point> surface;
  CGAL::convex_hull_3(cloud.begin(), cloud.end(), surface);
  TriangleMesh hull;
  for (const auto vertex : surface.vertices()) {
    const Point& corner = surface.point(vertex);
    hull.vertices_m.emplace_back(corner.x(), corner.y(), corner.z());
  }
  for (const auto face : surface.faces()) {
    std::array<uint32_t, 3> triangle;
    size_t k = 0;
    for (const auto vertex : surface.vertices_around_face(surface.halfedge(face))) {
      if (k < 3) triangle[k] = static_cast<uint32_t>(vertex.idx());
      ++k;
    }
    if (k == 3) hull.triangles.push_back(triangle);
  }
  put_in_order(hull);
  if (!mesh_topology(hull).closed || !(signed_volume_m3(hull) > 0.0)) return {};
  return hull;
}

}  // namespace livegs

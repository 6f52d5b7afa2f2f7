// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/convex_hull.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>

#include "geometry/mesh_topology.h"

namespace livegs {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

// Exactly: no four of the points span a volume.
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

}  // namespace

TriangleMesh convex_hull(std::span<const Eigen::Vector3d> points_m) {
  std::vector<Point> cloud;
  cloud.reserve(points_m.size());
  for (const auto& point : points_m) cloud.emplace_back(point.x(), point.y(), point.z());
  // CGAL 5.5 makes of a flat cloud a polygon with indices past its corners, or throws.
  if (is_flat(cloud)) return {};
  // Into a Surface_mesh, which brings exactly decided planes along; the overload for plain arrays rounds
  // them, and thin bodies break it.
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
  if (!mesh_topology(hull).closed || !(signed_volume_m3(hull) > 0.0)) return {};
  return hull;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/convex_hull.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/convex_hull_3.h>

#include "geometry/mesh_topology.h"

namespace livegs {

TriangleMesh convex_hull(std::span<const Eigen::Vector3d> points_m) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> cloud;
  cloud.reserve(points_m.size());
  for (const auto& point : points_m) cloud.emplace_back(point.x(), point.y(), point.z());
  std::vector<Point> corners;
  std::vector<std::array<size_t, 3>> faces;
  if (cloud.size() >= 4) CGAL::convex_hull_3(cloud.begin(), cloud.end(), corners, faces);
  TriangleMesh hull;
  for (const Point& corner : corners) hull.vertices_m.emplace_back(corner.x(), corner.y(), corner.z());
  for (const auto& [a, b, c] : faces) {
    hull.triangles.push_back({static_cast<uint32_t>(a), static_cast<uint32_t>(b), static_cast<uint32_t>(c)});
  }
  if (!mesh_topology(hull).closed || !(signed_volume_m3(hull) > 0.0)) return {};
  return hull;
}

}  // namespace livegs

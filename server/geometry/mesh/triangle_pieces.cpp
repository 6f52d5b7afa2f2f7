// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/triangle_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace livegs {

void for_each_triangle_piece(
    const TriangleMesh& mesh, double edge_m,
    const std::function<void(const Eigen::Vector3d& centre_m, double area_m2)>& visit) {
  constexpr double kMaxPartsOfEdge = 512.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& p = mesh.vertices_m[a];
    const Eigen::Vector3d u = mesh.vertices_m[b] - p, v = mesh.vertices_m[c] - p;
    const double longest_m = std::sqrt(std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()}));
    const int parts = static_cast<int>(std::clamp(std::ceil(longest_m / edge_m), 1.0, kMaxPartsOfEdge));
    const double area_m2 = 0.5 * u.cross(v).norm() / (static_cast<double>(parts) * parts);
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; j < parts - i; ++j) {
        visit(p + ((i + 1.0 / 3.0) * u + (j + 1.0 / 3.0) * v) / parts, area_m2);
        // The adjacent inverted triangle.
        if (j < parts - i - 1) visit(p + ((i + 2.0 / 3.0) * u + (j + 2.0 / 3.0) * v) / parts, area_m2);
      }
    }
  }
}

}  // namespace livegs

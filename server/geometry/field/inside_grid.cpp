// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/field/inside_grid.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

// Crossing of the edge a→b with the half-line from (y, z) towards +y, seen along x: +1 or -1 for upwards or
// downwards in z, else 0. Swapping a and b changes only the sign.
int edge_crossing(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double y, double z) {
  if ((a.z() > z) == (b.z() > z)) return 0;
  const bool upwards = b.z() > z;
  const Eigen::Vector3d& low = upwards ? a : b;
  const Eigen::Vector3d& high = upwards ? b : a;
  const double side = (high.y() - low.y()) * (z - low.z()) - (high.z() - low.z()) * (y - low.y());
  if (!(side > 0.0)) return 0;
  return upwards ? 1 : -1;
}

// Returns the nodes of one axis within [low, high], clamped to the grid: first index and one past the last.
std::pair<int, int> node_range(double low, double high, double origin, double cell, int count) {
  const double limit = count;
  const double first = std::clamp(std::ceil((low - origin) / cell - 1e-9), 0.0, limit);
  const double last = std::clamp(std::floor((high - origin) / cell + 1e-9) + 1.0, 0.0, limit);
  return {static_cast<int>(first), static_cast<int>(last)};
}

}  // namespace

std::vector<uint8_t> nodes_inside(const TriangleMesh& mesh, const RegularGrid& grid) {
  const Eigen::Vector3i& counts = grid.counts;
  // Change of the winding number at the first node beyond each crossing.
  std::vector<int32_t> winding(grid.size(), 0);
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d &a = mesh.vertices_m[triangle[0]], &b = mesh.vertices_m[triangle[1]],
                          &c = mesh.vertices_m[triangle[2]];
    const Eigen::Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    const auto [j_begin, j_end] = node_range(low.y(), high.y(), grid.origin_m.y(), grid.cell_m, counts.y());
    const auto [k_begin, k_end] = node_range(low.z(), high.z(), grid.origin_m.z(), grid.cell_m, counts.z());
    if (j_begin == j_end || k_begin == k_end) continue;
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    for (int k = k_begin; k < k_end; ++k) {
      for (int j = j_begin; j < j_end; ++j) {
        const Eigen::Vector3d node = grid.point_m(0, j, k);
        const int exits = edge_crossing(a, b, node.y(), node.z()) + edge_crossing(b, c, node.y(), node.z()) +
                          edge_crossing(c, a, node.y(), node.z());
        if (exits == 0) continue;
        const double way = normal.y() * (node.y() - a.y()) + normal.z() * (node.z() - a.z());
        double x = normal.x() != 0.0 ? a.x() - way / normal.x() : low.x();
        x = std::clamp(x, low.x(), high.x());  // an edge-on triangle divides by almost zero
        const double beyond = std::floor((x - grid.origin_m.x()) / grid.cell_m) + 1.0;
        if (beyond >= counts.x()) continue;
        winding[grid.index(static_cast<int>(std::max(beyond, 0.0)), j, k)] -= exits;
      }
    }
  }
  std::vector<uint8_t> inside(grid.size());
  for (size_t row = 0; row < grid.size(); row += counts.x()) {
    int32_t sum = 0;
    for (int i = 0; i < counts.x(); ++i) {
      sum += winding[row + i];
      inside[row + i] = sum != 0;
    }
  }
  return inside;
}

}  // namespace livegs

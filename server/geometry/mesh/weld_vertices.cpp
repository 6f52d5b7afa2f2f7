// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/weld_vertices.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace livegs {

TriangleMesh weld_vertices(const TriangleMesh& mesh) {
  TriangleMesh welded;
  std::map<std::tuple<double, double, double>, uint32_t> number;
  for (const auto& triangle : mesh.triangles) {
    std::array<uint32_t, 3> corners;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = mesh.vertices_m[triangle[k]];
      const auto [found, is_new] = number.try_emplace(std::tuple(p.x(), p.y(), p.z()),
                                                      static_cast<uint32_t>(welded.vertices_m.size()));
      if (is_new) welded.vertices_m.push_back(p);
      corners[k] = found->second;
    }
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) {
      welded.triangles.push_back(corners);
    }
  }
  return welded;
}

size_t open_edge_count(const TriangleMesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  for (const auto& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = triangle[k], to = triangle[(k + 1) % 3];
      balance[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  return static_cast<size_t>(
      std::count_if(balance.begin(), balance.end(), [](const auto& edge) { return edge.second != 0; }));
}

}  // namespace livegs

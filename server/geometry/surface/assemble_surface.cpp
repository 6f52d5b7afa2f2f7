// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/assemble_surface.h"

#include <algorithm>
#include <tuple>

#include "core/disjoint_sets.h"

namespace livegs {
namespace {

constexpr uint32_t kNone = UINT32_MAX;

uint32_t next_in_triangle(uint32_t half_edge) { return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1; }

// Returns for each half-edge the vertex at its midpoint, shared with its twin, if another pair has the same
// ends.
std::vector<uint32_t> split_doubled_edges(const PairedTriangles& surface, TriangleMesh& mesh) {
  struct Pair {
    uint32_t low, high, half_edge;
  };
  std::vector<Pair> pairs;
  pairs.reserve(surface.twins.size() / 2);
  for (uint32_t h = 0; h < surface.twins.size(); ++h) {
    if (surface.twins[h] < h) continue;
    const uint32_t a = mesh.triangles[h / 3][h % 3], b = mesh.triangles[h / 3][(h + 1) % 3];
    pairs.push_back({std::min(a, b), std::max(a, b), h});
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.low, a.high, a.half_edge) < std::tie(b.low, b.high, b.half_edge);
  });
  std::vector<uint32_t> middles(surface.twins.size(), kNone);
  for (size_t i = 1; i < pairs.size(); ++i) {
    if (pairs[i].low != pairs[i - 1].low || pairs[i].high != pairs[i - 1].high) continue;
    const auto middle = static_cast<uint32_t>(mesh.vertices_m.size());
    mesh.vertices_m.push_back(0.5 * (mesh.vertices_m[pairs[i].low] + mesh.vertices_m[pairs[i].high]));
    middles[pairs[i].half_edge] = middles[surface.twins[pairs[i].half_edge]] = middle;
  }
  return middles;
}

}  // namespace

TriangleMesh assemble_surface(const PairedTriangles& surface,
                              const std::function<Eigen::Vector3d(uint32_t point)>& position) {
  // Half-edge h represents its start corner. Around a vertex, the end of the twin is the same corner.
  DisjointSets fans(surface.twins.size());
  for (uint32_t h = 0; h < surface.twins.size(); ++h) fans.join(h, next_in_triangle(surface.twins[h]));

  TriangleMesh mesh;
  std::vector<uint32_t> vertex_of_fan(surface.twins.size(), kNone);
  for (uint32_t t = 0; t < surface.corners.size(); ++t) {
    std::array<uint32_t, 3> triangle;
    for (uint32_t k = 0; k < 3; ++k) {
      uint32_t& vertex = vertex_of_fan[fans.find(3 * t + k)];
      if (vertex == kNone) {
        vertex = static_cast<uint32_t>(mesh.vertices_m.size());
        mesh.vertices_m.push_back(position(surface.corners[t][k]));
      }
      triangle[k] = vertex;
    }
    mesh.triangles.push_back(triangle);
  }

  const std::vector<uint32_t> middles = split_doubled_edges(surface, mesh);
  const size_t triangle_count = mesh.triangles.size();
  for (size_t t = 0; t < triangle_count; ++t) {
    std::array<uint32_t, 3> v = mesh.triangles[t];
    std::array<uint32_t, 3> m{middles[3 * t], middles[3 * t + 1],
                              middles[3 * t + 2]};  // of edges v0v1, v1v2, v2v0
    const auto splits = 3 - std::count(m.begin(), m.end(), kNone);
    if (splits == 0) continue;
    // Rotated so that one split is on the first edge, and two splits are on the first and second edge.
    while (m[0] == kNone || (splits == 2 && m[1] == kNone)) {
      std::rotate(v.begin(), v.begin() + 1, v.end());
      std::rotate(m.begin(), m.begin() + 1, m.end());
    }
    auto& triangles = mesh.triangles;
    if (splits == 1) {
      triangles[t] = {v[0], m[0], v[2]};
      triangles.push_back({m[0], v[1], v[2]});
    } else if (splits == 2) {
      triangles[t] = {m[0], v[1], m[1]};
      triangles.insert(triangles.end(), {{v[0], m[0], m[1]}, {v[0], m[1], v[2]}});
    } else {
      triangles[t] = {m[0], m[1], m[2]};
      triangles.insert(triangles.end(), {{v[0], m[0], m[2]}, {m[0], v[1], m[1]}, {m[2], m[1], v[2]}});
    }
  }
  return mesh;
}

}  // namespace livegs

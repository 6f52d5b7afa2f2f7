// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh/mesh_topology.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "core/disjoint_sets.h"

namespace livegs {
namespace {

// A directed edge of a triangle, sorted by its undirected edge first.
struct HalfEdge {
  uint32_t low, high;
  bool forward;  // direction is from low to high
  uint32_t triangle;
  auto edge() const { return std::pair(low, high); }
};

std::vector<HalfEdge> sorted_half_edges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(mesh.triangles.size() * 3);
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = mesh.triangles[t][k], to = mesh.triangles[t][(k + 1) % 3];
      half_edges.push_back({std::min(from, to), std::max(from, to), from < to, t});
    }
  }
  std::sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tuple(a.low, a.high, a.triangle) < std::tuple(b.low, b.high, b.triangle);
  });
  return half_edges;
}

uint32_t corner_of(const TriangleMesh& mesh, uint32_t triangle, uint32_t vertex) {
  const auto& corners = mesh.triangles[triangle];
  return triangle * 3 + (corners[0] == vertex ? 0u : corners[1] == vertex ? 1u : 2u);
}

}  // namespace

MeshTopology mesh_topology(const TriangleMesh& mesh) {
  MeshTopology topology;
  topology.closed = !mesh.triangles.empty();
  bool pairs_only = true;
  int edge_count = 0;
  // Corners that share an edge at the same vertex belong to one fan.
  DisjointSets fans(mesh.triangles.size() * 3);
  const std::vector<HalfEdge> half_edges = sorted_half_edges(mesh);
  for (size_t begin = 0; begin < half_edges.size();) {
    size_t end = begin;
    int balance = 0;
    while (end < half_edges.size() && half_edges[end].edge() == half_edges[begin].edge()) {
      balance += half_edges[end].forward ? 1 : -1;
      for (uint32_t vertex : {half_edges[end].low, half_edges[end].high}) {
        fans.join(corner_of(mesh, half_edges[begin].triangle, vertex),
                  corner_of(mesh, half_edges[end].triangle, vertex));
      }
      ++end;
    }
    if (balance != 0 || half_edges[begin].low == half_edges[begin].high) topology.closed = false;
    if (end - begin != 2) pairs_only = false;
    ++edge_count;
    begin = end;
  }
  std::vector<uint32_t> fan_of_vertex(mesh.vertices_m.size(), UINT32_MAX);
  bool one_fan = true;
  int vertex_count = 0;
  for (uint32_t corner = 0; corner < mesh.triangles.size() * 3; ++corner) {
    uint32_t& fan = fan_of_vertex[mesh.triangles[corner / 3][corner % 3]];
    if (fan == UINT32_MAX) {
      fan = fans.find(corner);
      ++vertex_count;
    } else if (fan != fans.find(corner)) {
      one_fan = false;
    }
  }
  topology.manifold = topology.closed && pairs_only && one_fan;
  topology.euler_characteristic = vertex_count - edge_count + static_cast<int>(mesh.triangles.size());
  const std::vector<int> pieces = mesh_pieces(mesh);
  topology.piece_count = pieces.empty() ? 0 : *std::max_element(pieces.begin(), pieces.end()) + 1;
  return topology;
}

std::vector<int> mesh_pieces(const TriangleMesh& mesh) {
  DisjointSets joined(mesh.vertices_m.size());
  for (const auto& triangle : mesh.triangles) {
    joined.join(triangle[0], triangle[1]);
    joined.join(triangle[0], triangle[2]);
  }
  std::vector<int> number(mesh.vertices_m.size(), -1);
  std::vector<int> pieces;
  pieces.reserve(mesh.triangles.size());
  int count = 0;
  for (const auto& triangle : mesh.triangles) {
    int& piece = number[joined.find(triangle[0])];
    if (piece < 0) piece = count++;
    pieces.push_back(piece);
  }
  return pieces;
}

double signed_volume_m3(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0.0;
  // A point near the mesh, against cancellation.
  const Eigen::Vector3d origin = mesh.vertices_m[mesh.triangles[0][0]];
  double six_volumes = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d p = mesh.vertices_m[a] - origin;
    six_volumes += p.dot((mesh.vertices_m[b] - origin).cross(mesh.vertices_m[c] - origin));
  }
  return six_volumes / 6.0;
}

Eigen::AlignedBox3d mesh_bounds_m(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d bounds;
  for (const auto& triangle : mesh.triangles) {
    for (uint32_t vertex : triangle) bounds.extend(mesh.vertices_m[vertex]);
  }
  return bounds;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/remove_small_components.h"

#include <algorithm>
#include <vector>

#include "geometry/mesh/mesh_topology.h"

namespace livegs {
namespace {

constexpr double kMinComponentVolume = 1e-3;  // relative to the whole
constexpr double kMinComponentLength = 0.05;  // relative to the diagonal of the whole

}  // namespace

SmallComponents remove_small_components(TriangleMesh& mesh) {
  const std::vector<int> piece_of = mesh_pieces(mesh);
  if (piece_of.empty()) return {};
  struct Piece {
    double volume = 0.0;
    Eigen::AlignedBox3d bounds;
  };
  std::vector<Piece> pieces(static_cast<size_t>(*std::max_element(piece_of.begin(), piece_of.end())) + 1);
  if (pieces.size() == 1) return {};
  const Eigen::AlignedBox3d whole = mesh_bounds_m(mesh);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    Piece& piece = pieces[piece_of[t]];
    for (uint32_t vertex : mesh.triangles[t]) piece.bounds.extend(mesh.vertices_m[vertex]);
    const Eigen::Vector3d p = mesh.vertices_m[a] - whole.center();
    piece.volume +=
        p.dot((mesh.vertices_m[b] - whole.center()).cross(mesh.vertices_m[c] - whole.center())) / 6.0;
  }
  double volume = 0.0;
  size_t largest = 0;
  for (size_t i = 0; i < pieces.size(); ++i) {
    volume += pieces[i].volume;
    if (pieces[i].volume > pieces[largest].volume) largest = i;
  }
  SmallComponents dropped;
  std::vector<bool> keep(pieces.size(), true);
  for (size_t i = 0; i < pieces.size(); ++i) {
    if (i == largest || pieces[i].volume >= kMinComponentVolume * volume) continue;
    if (pieces[i].bounds.diagonal().norm() >= kMinComponentLength * whole.diagonal().norm()) continue;
    keep[i] = false;
    ++dropped.count;
    dropped.volume_share += pieces[i].volume / volume;
  }
  if (dropped.count == 0) return dropped;
  std::vector<std::array<uint32_t, 3>> kept;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (keep[piece_of[t]]) kept.push_back(mesh.triangles[t]);
  }
  mesh.triangles = std::move(kept);
  remove_unused_vertices(mesh);
  return dropped;
}

void remove_unused_vertices(TriangleMesh& mesh) {
  std::vector<uint32_t> new_index(mesh.vertices_m.size(), UINT32_MAX);
  for (const auto& triangle : mesh.triangles) {
    for (uint32_t vertex : triangle) new_index[vertex] = 0;
  }
  uint32_t count = 0;
  for (size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] == UINT32_MAX) continue;
    mesh.vertices_m[count] = mesh.vertices_m[v];
    new_index[v] = count++;
  }
  mesh.vertices_m.resize(count);
  for (auto& triangle : mesh.triangles) {
    for (uint32_t& vertex : triangle) vertex = new_index[vertex];
  }
}

}  // namespace livegs

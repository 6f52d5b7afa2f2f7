// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/lattice/lattice.h"

#include <algorithm>
#include <cmath>

#include "core/disjoint_sets.h"
#include "skin/kernels/cell_fill.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Particles outside all cells are embedded in the nearest one, clamped to this local coordinate.
constexpr double kMaxLocal = 2.0;

}  // namespace

std::array<double, 8> trilinear_weights(const Vector3d& local) {
  std::array<double, 8> weights;
  for (int c = 0; c < 8; ++c) {
    weights[c] = 0.125 * (c & 1 ? 1.0 + local.x() : 1.0 - local.x()) *
                 (c & 2 ? 1.0 + local.y() : 1.0 - local.y()) * (c & 4 ? 1.0 + local.z() : 1.0 - local.z());
  }
  return weights;
}

std::array<Vector3d, 8> trilinear_gradients(const Vector3d& local, double cell_width_m) {
  std::array<Vector3d, 8> gradients;
  for (int c = 0; c < 8; ++c) {
    const Vector3d sign = corner_sign(c), f = Vector3d::Ones() + sign.cwiseProduct(local);
    gradients[c] = Vector3d(sign.x() * f.y() * f.z(), sign.y() * f.z() * f.x(), sign.z() * f.x() * f.y()) /
                   (4.0 * cell_width_m);
  }
  return gradients;
}

Vector3d Lattice::node_position_m(size_t node) const {
  return object_from_lattice * (cell_width_m * node_coordinates[node].cast<double>());
}

int piece_count(const Lattice& lattice) {
  DisjointSets parts(lattice.node_coordinates.size());
  for (const LatticeCell& cell : lattice.cells) {
    for (const uint32_t node : cell.nodes) parts.join(cell.nodes[0], node);
  }
  int count = 0;
  for (uint32_t i = 0; i < lattice.node_coordinates.size(); ++i) count += parts.find(i) == i;
  return count;
}

EmbeddedPoint Lattice::embed(const Vector3d& object_point_m) const {
  const Vector3d point = object_from_lattice.orientation.conjugate() *
                         (object_point_m - object_from_lattice.position_m) / cell_width_m;
  const auto local_in = [&](const LatticeCell& cell) -> Vector3d {
    return 2.0 * (point - cell.coordinates.cast<double>()) - Vector3d::Ones();
  };
  EmbeddedPoint nearest;
  FillDistance least{INFINITY, INFINITY, INFINITY};
  const auto consider = [&](uint32_t i) {
    const LatticeCell& cell = cells[i];
    const Eigen::Vector3f in_cell = (point - cell.coordinates.cast<double>()).cast<float>();
    const FillDistance distance = fill_distance(has_virtual_cells ? cell.fill : kFullCell, in_cell);
    if (!(distance < least)) return;
    least = distance;
    nearest.cell = i;
  };
  const auto consider_at = [&](const Vector3i& coordinates) {
    auto found = std::ranges::lower_bound(cells_by_place, lattice_key(coordinates), {},
                                          [&](uint32_t i) { return lattice_key(cells[i].coordinates); });
    for (; found != cells_by_place.end() && cells[*found].coordinates == coordinates; ++found)
      consider(*found);
  };
  // Guards the conversion to int; a point that fails is far outside in any case.
  if ((point.array().abs() < 1e9).all()) {
    const Vector3i own = point.array().floor().cast<int>();
    consider_at(own);
    for (int k = 0; k < 27 && least.to_material > 0.0f; ++k) {
      consider_at(own + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
    }
  }
  // All other cells are at least one cell away.
  if (least.to_material > 1.0f) {
    for (uint32_t i = 0; i < cells.size(); ++i) consider(i);
  }
  nearest.local = local_in(cells[nearest.cell]).cwiseMax(-kMaxLocal).cwiseMin(kMaxLocal);
  return nearest;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/lattice_order.h"

namespace livegs {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

// Particles outside every cell ride in the nearest one, at most this far beyond its faces (local coordinates).
constexpr double kFurthestLocal = 2.0;

}  // namespace

std::array<double, 8> trilinear_weights(const Vector3d& local) {
  std::array<double, 8> weights;
  for (int c = 0; c < 8; ++c) {
    weights[c] = 0.125 * (c & 1 ? 1.0 + local.x() : 1.0 - local.x()) * (c & 2 ? 1.0 + local.y() : 1.0 - local.y()) *
                 (c & 4 ? 1.0 + local.z() : 1.0 - local.z());
  }
  return weights;
}

std::array<Vector3d, 8> trilinear_gradients(const Vector3d& local, double cell_width_m) {
  std::array<Vector3d, 8> gradients;
  for (int c = 0; c < 8; ++c) {
    const Vector3d sign(c & 1 ? 1.0 : -1.0, c & 2 ? 1.0 : -1.0, c & 4 ? 1.0 : -1.0);
    const Vector3d f = Vector3d::Ones() + sign.cwiseProduct(local);
    gradients[c] = Vector3d(sign.x() * f.y() * f.z(), sign.y() * f.z() * f.x(), sign.z() * f.x() * f.y()) /
                   (4.0 * cell_width_m);
  }
  return gradients;
}

Vector3d Lattice::node_position_m(size_t node) const {
  return object_from_lattice * (cell_width_m * node_coordinates[node].cast<double>());
}

EmbeddedPoint Lattice::embed(const Vector3d& object_point_m) const {
  const Vector3d point = object_from_lattice.orientation.conjugate() *
                         (object_point_m - object_from_lattice.position_m) / cell_width_m;
  const auto local_in = [&](const LatticeCell& cell) -> Vector3d {
    return 2.0 * (point - cell.coordinates.cast<double>()) - Vector3d::Ones();
  };
  EmbeddedPoint nearest;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](uint32_t i) {
    const double beyond = (local_in(cells[i]).cwiseAbs() - Vector3d::Ones()).cwiseMax(0.0).squaredNorm();
    if (beyond >= least) return;
    least = beyond;
    nearest.cell = i;
  };
  const auto consider_at = [&](const Vector3i& coordinates) {
    LatticeCell sought;
    sought.coordinates = coordinates;
    const auto found = std::lower_bound(cells.begin(), cells.end(), sought, [](const auto& a, const auto& b) {
      return cell_order(a) < cell_order(b);
    });
    if (found != cells.end() && found->coordinates == coordinates) consider(static_cast<uint32_t>(found - cells.begin()));
  };
  // Within reach of int and finite, or it is far outside anyway.
  if ((point.array().abs() < 1e9).all()) {
    const Vector3i own(static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y())),
                       static_cast<int>(std::floor(point.z())));
    consider_at(own);
    for (int k = 0; k < 27 && least > 0.0; ++k) consider_at(own + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
  }
  // Any other cell is a whole cell away: two local units.
  if (least > 4.0) {
    for (uint32_t i = 0; i < cells.size(); ++i) consider(i);
  }
  nearest.local = local_in(cells[nearest.cell]).cwiseMax(-kFurthestLocal).cwiseMin(kFurthestLocal);
  return nearest;
}

}  // namespace livegs

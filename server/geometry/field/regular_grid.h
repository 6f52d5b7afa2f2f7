// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

namespace livegs {

// The most nodes a grid of this room has (a few bytes each): what a wrong scale or spacing may cost.
inline constexpr double kMaxGridNodes = double{1 << 23};

// Nodes of a cubic grid, x fastest.
struct RegularGrid {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // of node (0, 0, 0)
  double cell_m = 1.0;
  Eigen::Vector3i counts = Eigen::Vector3i::Ones();

  size_t size() const { return static_cast<size_t>(counts.x()) * counts.y() * counts.z(); }
  size_t index(int i, int j, int k) const {
    return static_cast<size_t>(i) +
           static_cast<size_t>(counts.x()) * (j + static_cast<size_t>(counts.y()) * k);
  }
  Eigen::Vector3d point_m(int i, int j, int k) const { return origin_m + cell_m * Eigen::Vector3d(i, j, k); }
};

// A cell, `cell_m` or as much wider as it takes, with which a grid over `size_m` has no more than max_nodes.
inline double affordable_cell_m(double cell_m, const Eigen::Vector3d& size_m,
                                double max_nodes = kMaxGridNodes) {
  while (((size_m / cell_m).array() + 2.0).prod() > max_nodes) cell_m *= 1.25;
  return cell_m;
}

}  // namespace livegs

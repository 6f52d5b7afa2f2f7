// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

namespace livegs {

// Maximum number of nodes of a grid (a few bytes each). Limits the memory that a wrong scale or spacing can
// use.
inline constexpr double kMaxGridNodes = double{1 << 23};

// Nodes of a cubic grid, x fastest.
struct RegularGrid {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  // position of node (0, 0, 0)
  double cell_m = 1.0;
  Eigen::Vector3i counts = Eigen::Vector3i::Ones();

  size_t size() const { return static_cast<size_t>(counts.x()) * counts.y() * counts.z(); }
  size_t index(int i, int j, int k) const {
    return static_cast<size_t>(i) +
           static_cast<size_t>(counts.x()) * (j + static_cast<size_t>(counts.y()) * k);
  }
  Eigen::Vector3d point_m(int i, int j, int k) const { return origin_m + cell_m * Eigen::Vector3d(i, j, k); }
};

// Returns `cell_m`, enlarged as far as necessary for a grid over `size_m` to have at most max_nodes nodes.
inline double affordable_cell_m(double cell_m, const Eigen::Vector3d& size_m,
                                double max_nodes = kMaxGridNodes) {
  while (((size_m / cell_m).array() + 2.0).prod() > max_nodes) cell_m *= 1.25;
  return cell_m;
}

}  // namespace livegs

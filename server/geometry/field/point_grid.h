// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "geometry/field/regular_grid.h"

namespace livegs {

// Points in cubic cells, for nearest-neighbour queries. Points are numbered in order of insertion; ties go to
// the lower number.
class PointGrid {
 public:
  // All points must lie within `bounds_m`. Cells are cell_m wide, or wider to limit their number.
  PointGrid(const Eigen::AlignedBox3d& bounds_m, double cell_m);

  void insert(const Eigen::Vector3d& point_m);
  size_t size() const { return points_m_.size(); }

  // Returns whether a point is closer than radius_m.
  bool has_neighbour_within(const Eigen::Vector3d& point_m, double radius_m) const;

  // Returns the number of the nearest point. Precondition: the grid is not empty.
  uint32_t nearest(const Eigen::Vector3d& point_m) const;

 private:
  Eigen::Vector3i cell_of(const Eigen::Vector3d& point_m) const;

  RegularGrid cells_;
  std::vector<int32_t> last_in_cell_;  // -1: empty
  std::vector<int32_t> one_before_;    // previous point in the same cell, or -1
  std::vector<Eigen::Vector3d> points_m_;
};

}  // namespace livegs

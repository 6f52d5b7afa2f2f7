// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "geometry/field/regular_grid.h"

// Private to the geometry room.

namespace livegs {

// Approximate colour of the nearest point, on a grid. A cell with points stores their mean colour. Other
// cells are filled layer by layer with the mean of their filled neighbours. Immutable; any thread.
class ColourGrid {
 public:
  // Precondition: finite colours and at least one point. The grid has about a hundred thousand cells.
  ColourGrid(std::span<const Eigen::Vector3d> points_m, std::span<const Eigen::Vector3f> colours);

  // Returns the colour at a point. Points outside the grid get the colour of its border.
  Eigen::Vector3f at(const Eigen::Vector3d& point_m) const { return colours_[cell_of(point_m)]; }

 private:
  size_t cell_of(const Eigen::Vector3d& point_m) const;

  RegularGrid grid_;
  std::vector<Eigen::Vector3f> colours_;
};

}  // namespace livegs

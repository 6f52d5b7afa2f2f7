// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "geometry/field/regular_grid.h"

// Inside the room.

namespace livegs {

// The colour of what lies nearest, roughly: cells with points have their mean, others, layer by layer from
// those, the mean of the cells beside them that came before. Immutable; any thread.
class ColourGrid {
 public:
  // Colours are finite; there is at least one point. About a hundred thousand cells.
  ColourGrid(std::span<const Eigen::Vector3d> points_m, std::span<const Eigen::Vector3f> colours);

  // Points outside the box of the points go with its border.
  Eigen::Vector3f at(const Eigen::Vector3d& point_m) const { return colours_[cell_of(point_m)]; }

 private:
  size_t cell_of(const Eigen::Vector3d& point_m) const;

  RegularGrid grid_;
  std::vector<Eigen::Vector3f> colours_;
};

}  // namespace livegs

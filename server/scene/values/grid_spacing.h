// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs {

// Returns the step of the cubic grid that the points were jittered from, each by less than half a step, or 0
// if no grid is detected. Searches along the world axes and the points' principal axes, between 0.9 and 1.8
// times `nearest_m`, the median distance to the nearest other point. The method is the structure factor, as
// for lattice constants in powder diffraction. Random jitter does not move its peak. A jitter of up to j
// steps per axis lowers it by the factor sinc(2 pi j).
double grid_spacing_m(const std::vector<Eigen::Vector3d>& points_m, double nearest_m);

}  // namespace livegs

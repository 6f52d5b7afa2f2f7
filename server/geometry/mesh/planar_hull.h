// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs {

// Corners of the convex hull of points in a plane, counter-clockwise from the point with the least x; empty
// if all points lie on a line. Monotone chain (Andrew 1979). Pure function.
std::vector<Eigen::Vector2d> planar_hull(std::vector<Eigen::Vector2d> points);

}  // namespace livegs

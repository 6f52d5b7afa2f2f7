// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace livegs {

// Returns the point of the triangle (a, b, c) nearest to p; degenerate triangles are allowed. Uses the
// Voronoi regions of the triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5).
Eigen::Vector3d closest_point_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                          const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace livegs

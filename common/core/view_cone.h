// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace livegs {

// The cone that a viewer looks into, world frame. `forward` has length 1. half_angle_rad is 0 to pi; pi
// covers all directions.
struct ViewCone {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d forward = -Eigen::Vector3d::UnitZ();
  double half_angle_rad = M_PI;

  // Whether a ball may intersect the cone. Conservative: never false for a ball that intersects it.
  bool touches(const Eigen::Vector3d& centre_m, double radius_m) const {
    const Eigen::Vector3d to_centre = centre_m - position_m;
    const double distance_m = to_centre.norm();
    if (distance_m <= radius_m) return true;
    const double angle_rad = std::acos(std::clamp(to_centre.dot(forward) / distance_m, -1.0, 1.0));
    return angle_rad <= half_angle_rad + std::asin(radius_m / distance_m);
  }
};

}  // namespace livegs

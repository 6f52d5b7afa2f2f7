// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid_motion.h"

#include <cmath>

namespace livegs {

Eigen::Quaterniond rotation_exp(const Eigen::Vector3d& angle_rad) {
  const double half = 0.5 * angle_rad.norm();
  // sin(x)/x by its series where the quotient would lose digits: the next term is below 1e-17 there.
  const double sinc = half > 1e-4 ? std::sin(half) / half : 1.0 - half * half / 6.0;
  Eigen::Quaterniond turn;
  turn.w() = std::cos(half);
  turn.vec() = 0.5 * sinc * angle_rad;
  return turn;
}

Eigen::Matrix3d rotated_tensor(const Eigen::Quaterniond& world_from_body, const Eigen::Matrix3d& tensor) {
  const Eigen::Matrix3d rotation = world_from_body.toRotationMatrix();
  return rotation * tensor * rotation.transpose();
}

Eigen::Quaterniond turned_freely(const Eigen::Quaterniond& orientation, const Eigen::Matrix3d& inverse_inertia_body,
                                 const Eigen::Vector3d& momentum, double duration_s) {
  Eigen::Vector3d velocity = rotated_tensor(orientation, inverse_inertia_body) * momentum;
  for (int iteration = 0; iteration < 2; ++iteration) {
    const Eigen::Quaterniond midpoint = rotation_exp(0.5 * duration_s * velocity) * orientation;
    velocity = rotated_tensor(midpoint, inverse_inertia_body) * momentum;
  }
  return (rotation_exp(duration_s * velocity) * orientation).normalized();
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace livegs {

// Matrix of the cross product: cross_matrix(v) * w = v.cross(w).
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// `v` scaled down to the length `max_norm` if it is longer.
inline Eigen::Vector3d clamp_norm(const Eigen::Vector3d& v, double max_norm) {
  const double norm = v.norm();
  return norm > max_norm ? Eigen::Vector3d(max_norm / norm * v) : v;
}

}  // namespace livegs

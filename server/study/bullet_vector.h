// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <LinearMath/btVector3.h>

#include <Eigen/Core>

namespace livegs::study {

inline btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
inline Eigen::Vector3d from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace livegs::study

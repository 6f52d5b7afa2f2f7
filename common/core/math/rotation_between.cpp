// SPDX-License-Identifier: Apache-2.0
#include "core/math/rotation_between.h"

namespace livegs {

Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

Eigen::Quaternionf float_rotation_between(const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
  return Eigen::Quaternionf::FromTwoVectors(from, to);
}

}  // namespace livegs

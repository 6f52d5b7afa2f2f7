// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace livegs {

// The shortest rotation from the direction of `from` to that of `to`: Quaternion::FromTwoVectors, compiled
// once. It has a singular value decomposition for opposite vectors, which each source would instantiate.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);
Eigen::Quaternionf float_rotation_between(const Eigen::Vector3f& from, const Eigen::Vector3f& to);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace livegs {

// The shortest rotation, as a unit quaternion, from the direction of `from` to that of `to`. Between opposite
// directions, its axis is the part of z across them, or of x if they are along z. Quaternion::FromTwoVectors
// finds an axis by a singular value decomposition, which takes several seconds to compile.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace livegs

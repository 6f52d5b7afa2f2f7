// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace livegs {

// A rigid transform with a unit quaternion. Names give target and source from right to left: `world_from_body
// * point_in_body`. Right-handed, +Y up, metres, as in OpenXR.
struct Pose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return orientation * point + position_m; }
  Pose operator*(const Pose& inner) const {
    return {orientation * inner.position_m + position_m, (orientation * inner.orientation).normalized()};
  }
  Pose inverse() const {
    const Eigen::Quaterniond back = orientation.conjugate();
    return {back * -position_m, back};
  }
};

// A rotation, a uniform scale and a translation: `to = scale * (rotation * from) + translation_m`. Applied
// once per object, from the units and axes of its asset file to metres with +Y up.
struct Similarity {
  double scale = 1.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + translation_m;
  }
};

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "viewer/author/object_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/math/nearest_rotation.h"

namespace livegs {
namespace {

// Best fit of a rotation and a translation from rest points to current ones (Kabsch 1976).
Pose fitted(const Eigen::Matrix3Xd& rest_m, const Eigen::Matrix3Xd& now_m) {
  const Eigen::Vector3d rest_centre = rest_m.rowwise().mean(), now_centre = now_m.rowwise().mean();
  const Eigen::Matrix3d covariance =
      (now_m.colwise() - now_centre) * (rest_m.colwise() - rest_centre).transpose();
  const Eigen::Matrix3d rotation = nearest_rotation(covariance);
  return {now_centre - rotation * rest_centre, Eigen::Quaterniond(rotation).normalized()};
}

Pose body_frame(const RestBody& rest, const ObjectDrivers& drivers) {
  if (drivers.kind == DriverKind::Rigid) {
    if (drivers.poses.empty() || rest.bodies.empty()) return {};
    return drivers.poses.front() * rest.bodies.front().inverse();
  }
  const bool lattice = drivers.kind == DriverKind::Lattice;
  const size_t count =
      std::min(drivers.positions_m.size(), lattice ? rest.node_coordinates.size() : rest.particles_m.size());
  if (count < 3) return {};
  Eigen::Matrix3Xd rest_m(3, count), now_m(3, count);
  for (size_t i = 0; i < count; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    rest_m.col(column) = lattice ? rest.object_from_lattice *
                                       (rest.cell_width_m * rest.node_coordinates[i].cast<double>()).eval()
                                 : rest.particles_m[i].cast<double>().eval();
    now_m.col(column) = drivers.positions_m[i].cast<double>();
  }
  return fitted(rest_m, now_m);
}

}  // namespace

Pose scene_pose(const RestBody& rest, const ObjectDrivers& drivers, double lift_m) {
  Pose pose = body_frame(rest, drivers);
  pose.position_m -= pose.orientation * Eigen::Vector3d(0.0, lift_m, 0.0);
  return pose;
}

Eigen::Vector3d yaw_pitch_roll_deg(const Eigen::Quaterniond& orientation) {
  const Eigen::Matrix3d r = orientation.toRotationMatrix();  // = Ry(yaw) Rx(pitch) Rz(roll)
  const double pitch = std::asin(std::clamp(-r(1, 2), -1.0, 1.0));
  double yaw = std::atan2(r(0, 2), r(2, 2)), roll = std::atan2(r(1, 0), r(1, 1));
  if (std::abs(r(1, 2)) > 1.0 - 1e-9) {  // only the sum or difference of yaw and roll is known
    yaw = std::atan2(-r(2, 0), r(0, 0));
    roll = 0.0;
  }
  return Eigen::Vector3d(yaw, pitch, roll) * (180.0 / M_PI);
}

Eigen::Quaterniond orientation_of(const Eigen::Vector3d& yaw_pitch_roll_deg) {
  const Eigen::Vector3d angles = yaw_pitch_roll_deg * (M_PI / 180.0);
  return (Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()))
      .normalized();
}

}  // namespace livegs

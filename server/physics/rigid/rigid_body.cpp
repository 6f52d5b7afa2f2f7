// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/rigid_body.h"

#include <Eigen/LU>
#include <algorithm>

namespace livegs {

void RigidBody::update_turning() {
  const Eigen::Matrix3d inverse = rotated_tensor(world_from_body.orientation, inverse_inertia_body());
  angular_velocity_rad_s = inverse * angular_momentum;
  inverse_mass = asleep ? 0.0 : 1.0 / mass_kg;
  inverse_inertia = asleep ? Eigen::Matrix3d::Zero().eval() : inverse;
}

void RigidBody::set_unit_inertia(const Eigen::Matrix3d& of_one_kg) {
  unit_inertia_body = 0.5 * (of_one_kg + of_one_kg.transpose());
  unit_axes = principal_axes(unit_inertia_body);
}

void RigidBody::wake() {
  asleep = false;
  still_s = 0.0;
  update_turning();
}

void RigidBody::sleep(uint64_t group) {
  asleep = true;
  sleep_group = group;
  velocity_m_s.setZero();
  angular_momentum.setZero();
  substep_velocity_m_s.setZero();
  substep_acceleration_m_s2.setZero();
  update_turning();
}

void RigidBody::set_angular_velocity(const Eigen::Vector3d& velocity_rad_s) {
  angular_momentum =
      rotated_tensor(world_from_body.orientation, mass_kg * unit_inertia_body) * velocity_rad_s;
  update_turning();
}

void RigidBody::apply_impulse(const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& arm_m) {
  if (asleep) return;
  velocity_m_s += inverse_mass * impulse_n_s;
  apply_angular_impulse(arm_m.cross(impulse_n_s));
}

void RigidBody::apply_angular_impulse(const Eigen::Vector3d& impulse) {
  if (asleep) return;
  angular_momentum += impulse;
  angular_velocity_rad_s += inverse_inertia * impulse;
}

Eigen::Vector3d RigidBody::mean_velocity(double duration_s) const {
  Eigen::Vector3d late = has_body_contact || joints ? Eigen::Vector3d(duration_s * substep_acceleration_m_s2)
                                                    : velocity_m_s - substep_velocity_m_s;
  for (const ContactManifold& manifold : manifolds) {
    for (int i = 0; i < manifold.point_count; ++i) {
      const ContactPoint& point = manifold.points[i];
      if (point.impulse_n_s > 0.0) late -= point.normal.dot(late) * point.normal;
    }
  }
  if (pushed_by_owner || !springs.empty()) late.setZero();
  return velocity_m_s - 0.5 * late;
}

Eigen::Quaterniond RigidBody::orientation_after(double duration_s) const {
  const Eigen::Quaterniond& now = world_from_body.orientation;
  if (!shape.is_ball()) return rotate_freely(now, unit_axes, angular_momentum / mass_kg, duration_s);
  return (rotation_exp(duration_s * angular_velocity_rad_s) * now).normalized();
}

void RigidBody::move(double duration_s) {
  world_from_body.position_m += duration_s * mean_velocity(duration_s);
  world_from_body.orientation = orientation_after(duration_s);
  update_turning();
}

double max_approach_m_s(const RigidBody& a, const RigidBody& b) {
  return (a.velocity_m_s - b.velocity_m_s).norm() +
         a.angular_velocity_rad_s.norm() * a.shape.bounding_radius_m +
         b.angular_velocity_rad_s.norm() * b.shape.bounding_radius_m;
}

double three_point_speed_m_s(const RigidBody& body) {
  const Eigen::Matrix3d axes = body.world_from_body.orientation.toRotationMatrix();
  double fastest = body.velocity_m_s.norm();
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector3d arm = body.shape.bounding_radius_m * axes.col(axis);
    fastest = std::max(fastest, (body.velocity_m_s + body.angular_velocity_rad_s.cross(arm)).norm());
  }
  return fastest;
}

}  // namespace livegs

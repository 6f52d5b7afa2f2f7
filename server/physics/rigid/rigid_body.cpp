// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/rigid_body.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

std::optional<double> sphere_distance(const Eigen::Vector3d& from_centre, const Eigen::Vector3d& direction,
                                      double radius) {
  const double along = from_centre.dot(direction);
  const double square = along * along - from_centre.squaredNorm() + radius * radius;
  if (square < 0.0) return std::nullopt;
  const double distance = -along - std::sqrt(square);
  return distance >= 0.0 ? std::optional(distance) : std::nullopt;
}

}  // namespace

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
  stop();
}

void RigidBody::stop() {
  velocity_m_s.setZero();
  angular_momentum.setZero();
  substep_velocity_m_s.setZero();
  substep_acceleration_m_s2.setZero();
  update_turning();
}

void RigidBody::record_force(const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& arm_m) {
  if (can_break) impacts.record_force(world_from_body.orientation, impulse_n_s, arm_m);
}

void RigidBody::record_joint(const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& point_m,
                             ImpulseKind kind, double remaining_s) {
  if (!can_break || asleep) return;
  impacts.record_joint(world_from_body.orientation, impulse_n_s, point_m - world_from_body.position_m, kind,
                       remaining_s);
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
    for (const ContactPoint& point : manifold.used()) {
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

// Möller, Trumbore 1997, Fast minimum storage ray/triangle intersection.
std::optional<double> ray_cast(const RigidBody& body, const Eigen::Vector3d& origin_m,
                               const Eigen::Vector3d& direction) {
  const Eigen::Vector3d from_centre = origin_m - body.world_from_body.position_m;
  if (body.shape.is_ball()) return sphere_distance(from_centre, direction, body.shape.sphere_radius_m);
  const double radius = body.shape.bounding_radius_m;
  if (from_centre.cross(direction).norm() > radius || from_centre.dot(direction) > radius)
    return std::nullopt;

  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  const Eigen::Vector3d origin = body_from_world * from_centre, ray = body_from_world * direction;
  std::optional<double> nearest;
  for (const auto& triangle : body.shape.mesh.triangles) {
    const Eigen::Vector3d& corner = body.shape.mesh.vertices_m[triangle[0]];
    const Eigen::Vector3d ab = body.shape.mesh.vertices_m[triangle[1]] - corner;
    const Eigen::Vector3d ac = body.shape.mesh.vertices_m[triangle[2]] - corner;
    const Eigen::Vector3d p = ray.cross(ac);
    const double determinant = ab.dot(p);
    if (determinant <= 0.0) continue;  // parallel or back-facing
    const Eigen::Vector3d t = origin - corner;
    const double u = t.dot(p);
    if (u < 0.0 || u > determinant) continue;
    const Eigen::Vector3d q = t.cross(ab);
    const double v = ray.dot(q);
    if (v < 0.0 || u + v > determinant) continue;
    const double distance = ac.dot(q) / determinant;
    if (distance >= 0.0 && (!nearest || distance < *nearest)) nearest = distance;
  }
  return nearest;
}

}  // namespace livegs

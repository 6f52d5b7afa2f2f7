// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/rigid_proxy.h"

#include <algorithm>

#include "physics/collision/conservative_advancement.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/vector_algebra.h"

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

void RigidProxy::begin_step(double began, double step, double substep_s) {
  before = began > 0.0 ? at_end() : start;
  began_s = began;
  step_s = step;
  elapsed_fraction = (began + step) / substep_s;
}

Pose RigidProxy::at_end() const {
  return {
      before.position_m + step_s * (velocity_m_s + elapsed_fraction * predicted_change_m_s),
      (rotation_exp(step_s * (spin_rad_s + elapsed_fraction * predicted_change_rad_s)) * before.orientation)
          .normalized()};
}

double RigidProxy::fastest_m_s() const {
  return (velocity_m_s + predicted_change_m_s).norm() +
         (spin_rad_s + predicted_change_rad_s).norm() * shape->bounding_radius_m;
}

ContactAnchor RigidProxy::anchor_at(const Vector3d& point_m, const Vector3d& application_m) const {
  const Vector3d point_before = before * Vector3d(at_end().inverse() * point_m);
  ContactAnchor anchor;
  anchor.arm_m = application_m - before.position_m;
  anchor.base_m = point_m - point_before - step_s * (velocity_m_s + spin_rad_s.cross(anchor.arm_m));
  return anchor;
}

Matrix3d RigidProxy::response(const ContactAnchor& anchor) const {
  const Matrix3d cross = cross_matrix(anchor.arm_m);
  return step_s * (inverse_mass * Matrix3d::Identity() - cross * inverse_inertia * cross);
}

Vector3d RigidProxy::displacement_m(const ContactAnchor& anchor) const {
  return anchor.base_m + step_s * (velocity_m_s + spin_rad_s.cross(anchor.arm_m));
}

void RigidProxy::apply_impulse(const ContactAnchor& anchor, const Vector3d&, const Vector3d& impulse) {
  const Vector3d turn = anchor.arm_m.cross(impulse);
  const Vector3d gained = inverse_mass * impulse, turned = inverse_inertia * turn;
  velocity_m_s += gained;
  spin_rad_s += turned;
  impulse_n_s += impulse;
  angular_impulse += turn;
  position_lag_m += began_s * gained;
  orientation_lag_rad += began_s * turned;
}

void RigidProxy::turn(const Vector3d& couple) {
  const Vector3d turned = inverse_inertia * couple;
  spin_rad_s += turned;
  angular_impulse += couple;
  orientation_lag_rad += began_s * turned;
}

void RigidProxy::record_impulse(const ContactAnchor&, const ContactImpulse& impulse) {
  const double size = impulse.impulse_n_s.norm();
  contact_impulse_n_s += size;
  contact_moment += size * impulse.point_m;
  step_impulse_n_s += size * (began_s + step_s) / (step_s * elapsed_fraction);
}

DistanceField::Sample swept_gap(const RigidShape& shape, const Vector3d& from_m, const Vector3d& to_m) {
  const Vector3d displacement = to_m - from_m;
  const double smallest = (shape.max_m - shape.min_m).minCoeff();
  if (displacement.norm() > kMaxUnsweptPart * smallest) {
    const auto sample = [&](const Vector3d& point) {
      const DistanceField::Sample found = shape.sample(point);
      return SurfaceSample{found.distance_m, found.gradient};
    };
    const auto hit = cast_sphere(sample, from_m, displacement, 0.0, 0.01 * smallest);
    if (hit) return {hit->separation_m + hit->normal.dot(displacement), hit->normal};
  }
  return shape.sample(to_m);
}

}  // namespace livegs

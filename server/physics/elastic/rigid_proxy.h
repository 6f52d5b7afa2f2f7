// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/pose.h"
#include "physics/collision/collision_shape.h"
#include "physics/elastic/contact_constraints.h"
#include "physics/surface_friction.h"

namespace livegs {

// A rigid body or ball as seen by elastic bodies during one world substep: a copy with velocities that change
// with every impulse, so that all elastic bodies see the same state. A sleeping body receives impulses as if
// awake; its owner wakes it if there were any. World frame; the centre is the centre of mass.
struct RigidProxy final : ContactParticipant {
  uint64_t body_id = 0;  // unique in the world
  const RigidShape* shape = nullptr;
  Pose start;  // world from body, at the start of the substep
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
  // Predicted change by gravity, rigid contacts and springs in this substep: the change in the last one.
  Eigen::Vector3d predicted_change_m_s = Eigen::Vector3d::Zero(),
                  predicted_change_rad_s = Eigen::Vector3d::Zero();
  double inverse_mass = 0.0;                                  // 1/kg
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  // world axes, at the start of the substep
  const SurfaceFriction* friction = nullptr;
  Eigen::Vector3d rest_centre_m = Eigen::Vector3d::Zero();  // as RigidBody::rest_centre_m
  bool asleep = false;

  // The current step of the elastic bodies: a part of the substep.
  Pose before;  // at the start of the step
  double began_s = 0.0, step_s = 0.0, elapsed_fraction = 0.0;

  // Output: impulses from elastic bodies. The angular impulse is about the centre at the start of each step;
  // angular momentum is then exact if the body follows this copy's motion.
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero(), angular_impulse = Eigen::Vector3d::Zero();
  // Displacement and rotation deficit, compared with all impulses applied at the start of the substep.
  Eigen::Vector3d position_lag_m = Eigen::Vector3d::Zero(), orientation_lag_rad = Eigen::Vector3d::Zero();
  double step_impulse_n_s = 0.0;     // sum of impulse magnitude times steps per substep
  double contact_impulse_n_s = 0.0;  // sum of magnitudes
  Eigen::Vector3d contact_moment = Eigen::Vector3d::Zero();  // sum of magnitude times point

  // `began_s` is the offset from the start of a substep of `substep_s`; 0 restarts the substep.
  void begin_step(double began_s, double step_s, double substep_s);
  Pose at_end() const;         // of the step, with the impulses so far
  double fastest_m_s() const;  // upper bound for all points
  double friction_at(const Eigen::Vector3d& body_point_m) const {
    return friction->at(rest_centre_m + body_point_m, shape->bounding_radius_m);
  }
  // Anchor of the material point that is at `point_m` at the end of the step. Impulses act at
  // `application_m`.
  ContactAnchor anchor_at(const Eigen::Vector3d& point_m, const Eigen::Vector3d& application_m) const;
  ContactAnchor anchor_at(const Eigen::Vector3d& point_m) const { return anchor_at(point_m, point_m); }

  void turn(const Eigen::Vector3d& couple_n_m_s);  // applies a couple during a step

  Eigen::Matrix3d response(const ContactAnchor& anchor) const override;
  Eigen::Vector3d displacement_m(const ContactAnchor& anchor) const override;
  void apply_impulse(const ContactAnchor& anchor, const Eigen::Vector3d& point_m,
                     const Eigen::Vector3d& impulse_n_s) override;
  void record_impulse(const ContactAnchor& anchor, const ContactImpulse& impulse) override;
};

// Gap and surface normal at the end of a point's motion from `from_m` to `to_m`, body frame of a moving body.
// A fast point is swept along its path, so that the result is the side that it came from.
DistanceField::Sample swept_gap(const RigidShape& shape, const Eigen::Vector3d& from_m,
                                const Eigen::Vector3d& to_m);

}  // namespace livegs

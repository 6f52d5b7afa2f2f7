// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/pose.h"
#include "physics/collision/collision_shape.h"
#include "physics/elastic/contact_constraints.h"

namespace livegs {

// A rigid body or ball as elastic bodies meet it during one substep of the world: a copy whose velocities
// change with every impulse it gets, so that bodies stepped after each other share it. A sleeping one takes
// impulses as if awake; who owns it wakes it when there were any. World frame; the centre is that of mass.
struct RigidProxy final : ContactParticipant {
  uint64_t body_id = 0;  // unique in the world
  const RigidShape* shape = nullptr;
  Pose start;  // world from body, at the start of the substep
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
  // What gravity, rigid contacts and springs are expected to add in this substep: what they did in the last
  // one.
  Eigen::Vector3d predicted_change_m_s = Eigen::Vector3d::Zero(),
                  predicted_change_rad_s = Eigen::Vector3d::Zero();
  double inverse_mass = 0.0;                                  // 1/kg
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  // world axes, at the start
  double friction = 0.5;
  bool asleep = false;

  // The step that an elastic body is taking: a part of the substep.
  Pose before;  // at its start
  double began_s = 0.0, step_s = 0.0, elapsed_fraction = 0.0;

  // Out: what elastic bodies gave it. The angular impulse is about the centre before each step, which keeps
  // angular momentum exactly when the body then goes as this copy did.
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero(), angular_impulse = Eigen::Vector3d::Zero();
  // How much less far it went, and turned, than if all impulses had come at the start of the substep.
  Eigen::Vector3d position_lag_m = Eigen::Vector3d::Zero(), orientation_lag_rad = Eigen::Vector3d::Zero();
  double step_impulse_n_s = 0.0;     // sum over impulses of size times steps in a substep
  double contact_impulse_n_s = 0.0;  // sizes
  Eigen::Vector3d contact_moment = Eigen::Vector3d::Zero();  // size times point

  // `began_s` after the start of a substep of `substep_s`; 0 begins another body's way through it.
  void begin_step(double began_s, double step_s, double substep_s);
  Pose at_end() const;         // of the step, with the impulses so far
  double fastest_m_s() const;  // of any of its points
  // The material point that is at `point_m` at the end of the step. Impulses act at `application_m` in space.
  ContactAnchor anchor_at(const Eigen::Vector3d& point_m, const Eigen::Vector3d& application_m) const;
  ContactAnchor anchor_at(const Eigen::Vector3d& point_m) const { return anchor_at(point_m, point_m); }

  void turn(const Eigen::Vector3d& couple_n_m_s);  // by a couple in the middle of a step

  Eigen::Matrix3d response(const ContactAnchor& anchor) const override;
  Eigen::Vector3d displacement_m(const ContactAnchor& anchor) const override;
  void apply_impulse(const ContactAnchor& anchor, const Eigen::Vector3d& point_m,
                     const Eigen::Vector3d& impulse_n_s) override;
  void record_impulse(const ContactAnchor& anchor, const Eigen::Vector3d& point_m,
                      const Eigen::Vector3d& impulse_n_s) override;
};

// Where the point is that goes from `from_m` to `to_m` (body frame of a moving body) at the end: its gap to
// the surface and the surface's normal there, body frame. A fast point is followed along its way, so that it
// finds the side it came from.
DistanceField::Sample swept_gap(const RigidShape& shape, const Eigen::Vector3d& from_m,
                                const Eigen::Vector3d& to_m);

}  // namespace livegs

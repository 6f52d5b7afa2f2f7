// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/contact/contact_friction.h"
#include "physics/rigid/contact/contact_point.h"

// Rows of contact manifolds, one contact at a time.

namespace livegs {

// Soft constraint: bias rate (1/s), and scale factors of the effective mass and of the accumulated impulse
// per solve. Catto 2024, Solver2D: soft step.
struct ContactSoftness {
  double bias_rate = 0, mass_scale = 1, impulse_scale = 0;
};
// Parameters of a contact spring with damping ratio 10 and a frequency f of a quarter of the step rate: 240
// Hz at 60 Hz with 4 substeps of 4 steps. A resting body sinks g / (2 pi f)².
ContactSoftness contact_softness(double step_s);
double contact_rate_rad_s(double step_s);  // 2 pi f

// Sweeps of a solver step (contact_lanes.h).
enum class ContactPhase {
  Push,   // overlaps are corrected softly
  Relax,  // velocities only: removes the energy added by the push
};
// Acceleration towards the surface by gravity and forces, at the centres of mass. `a` owns the manifold.
double closing_acceleration_m_s2(const RigidBody& a, const ContactManifold& manifold,
                                 const ContactPoint& point);
// Closing speed from which a contact is an impact: more than the acceleration adds meanwhile.
double impact_speed_m_s(const ContactManifold& manifold, double acceleration_m_s2, double step_s);

// Impacts (impact_phase.h), before the acceleration of a step of `step_s`.

// Response of two bodies to an impulse along one direction at one point.
struct ContactRow {
  Eigen::Vector3d direction;
  Eigen::Vector3d lever_a, lever_b;  // arm x direction
  Eigen::Vector3d turn_a, turn_b;    // inverse inertia times lever: spin change per unit impulse
  double mass_kg = 0;                // effective mass: impulse per change of speed
};

// The rows of a manifold.
struct ManifoldRows {
  std::array<ContactRow, kMaxManifoldPoints> points;
  ContactRow tangent, bitangent;
  Eigen::Vector3d twist_turn_a, twist_turn_b;
  ContactFriction<double> friction;
};
// Rows for the current poses, with the impulses of friction. Updates the arms of the manifold.
ManifoldRows prepare_rows(const RigidBody& a, ContactManifold& manifold);
// Marks the points that will touch in the step and close faster than the restitution speed, or than
// `passed_on_m_s` if that is positive and less, and sets the speed at which each leaves. Returns their
// fastest closing speed; 0: none. Precondition: the arms are those of the current poses.
double begin_impact(const RigidBody& a, ContactManifold& manifold, double step_s, double passed_on_m_s);
// One sweep over the marked points. Returns the largest change of speed, m/s.
double solve_impact(RigidBody& a, ContactManifold& manifold, const ManifoldRows& rows);
// One sweep of friction. Its impulses are those of the rows; store_friction copies them to the manifold.
void solve_friction(RigidBody& a, ContactManifold& manifold, ManifoldRows& rows);
void store_friction(ContactManifold& manifold, const ManifoldRows& rows);
double total_impulse(const ContactManifold& manifold);
// Rescales the accumulated impulses, for a next step that is `factor` times as long.
void scale_impulses(ContactManifold& manifold, double factor);

}  // namespace livegs

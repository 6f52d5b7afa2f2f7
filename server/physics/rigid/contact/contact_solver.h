// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/contact/contact_point.h"

// Sequential impulse solver for contact manifolds.

namespace livegs {

// Contact margin, as a fraction of the smaller bounding radius: closer surfaces are in contact at any speed.
// Larger: more contacts are kept. Smaller: contacts of resting bodies flicker.
inline constexpr double kContactMargin = 0.01;

// Soft constraint: bias rate (1/s), and scale factors of the effective mass and of the accumulated impulse
// per solve. Catto 2024, Solver2D: soft step.
struct ContactSoftness {
  double bias_rate = 0, mass_scale = 1, impulse_scale = 0;
};
// Parameters of a contact spring with damping ratio 10 and a frequency f of a quarter of the step rate: 240
// Hz at 60 Hz with 4 substeps of 4 steps. A resting body sinks g / (2 pi f)².
ContactSoftness contact_softness(double step_s);
double contact_rate_rad_s(double step_s);  // 2 pi f

// Phases of one solver step, in order. `a` owns the manifold.

// Computes effective masses and the arms of the other body for the current poses.
void prepare_manifold(RigidBody& a, ContactManifold& manifold);
void warm_start_manifold(RigidBody& a, ContactManifold& manifold);
enum class ContactPhase {
  Push,   // overlaps are corrected softly
  Relax,  // velocities only: removes the energy added by the push
};
void solve_manifold(RigidBody& a, ContactManifold& manifold, ContactPhase phase, double step_s);
// Updates separations after the bodies moved.
void update_separations(RigidBody& a, ContactManifold& manifold, double step_s);

// Impacts (impact_phase.h), before the acceleration of a step of `step_s`.
// Marks the points that will touch in the step and close faster than the restitution speed, or than
// `passed_on_m_s` if that is positive and less, and sets the speed at which each leaves. Returns their
// fastest closing speed; 0: none.
double begin_impact(const RigidBody& a, ContactManifold& manifold, double step_s, double passed_on_m_s);
// One sweep over the marked points. Returns the largest change of speed, m/s.
double solve_impact(RigidBody& a, ContactManifold& manifold);
void solve_friction(RigidBody& a, ContactManifold& manifold);  // friction only
double total_impulse(const ContactManifold& manifold);
// Rescales the accumulated impulses, for a next step that is `factor` times as long.
void scale_impulses(ContactManifold& manifold, double factor);

}  // namespace livegs

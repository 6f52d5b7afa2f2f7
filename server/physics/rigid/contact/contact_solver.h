// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/contact/contact_point.h"

// Contact between a rigid body and something else, solved.

namespace livegs {

// Surfaces closer than this part of the smaller bounding radius are in contact whatever their speed.
inline constexpr double kContactMargin = 0.01;

// Soft constraint: bias rate (1/s), and how much of mass and of accumulated impulse one solve takes.
// Catto 2024, Solver2D: soft step.
struct ContactSoftness {
  double bias_rate = 0, mass_scale = 1, impulse_scale = 0;
};
// Contact springs at a quarter of the step rate, damping ratio 10: 240 Hz at 60 Hz, 4 substeps of 4 steps. A
// body at rest sinks g / (2 pi f)^2 = 4 um.
ContactSoftness contact_softness(double step_s);

// The parts of one solver step, in the order of use. `a` owns the manifold.
void prepare_manifold(RigidBody& a,
                      ContactManifold& manifold);  // masses, and the same places seen from `other`, now
void warm_start_manifold(RigidBody& a, ContactManifold& manifold);
enum class ContactPhase {
  Push,   // overlaps are driven apart softly
  Relax,  // velocities only: takes the energy of the push out again
};
void solve_manifold(RigidBody& a, ContactManifold& manifold, ContactPhase phase, double step_s);
// After the bodies moved: separations follow.
void update_separations(RigidBody& a, ContactManifold& manifold, double step_s);
// Gives back what fell in. Returns whether anything bounced.
bool apply_restitution(RigidBody& a, ContactManifold& manifold);
void solve_friction(RigidBody& a, ContactManifold& manifold);  // friction alone
double total_impulse(const ContactManifold& manifold);

}  // namespace livegs

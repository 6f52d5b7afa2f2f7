// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "physics/rigid/rigid_islands.h"

// Impacts: surfaces that close faster than their restitution speed. They are resolved at one instant, before
// the step in which they would touch, so that the solver only supports resting contacts.
//
// Smith, Kaufman, Vouga, Tamstorf, Grinspun 2012, Reflections on Simultaneous Impact: all contacts that close
// are reflected together; this repeats while any closes. Together keeps symmetric impacts symmetric, in
// rounds passes an impulse along a row of touching bodies. With restitution e each contact of a round leaves
// at e times its closing speed. Without friction, energy cannot grow; with friction it is limited.

namespace livegs {

// Resolves the impacts of an island in the coming step. Requires prepared manifolds and velocities before the
// step's acceleration. `remaining_s`: from now to the end of the substep.
void resolve_impacts(const RigidIsland& island, std::span<JointGroup* const> joints, double step_s,
                     double remaining_s);

// Adds the impulses of a manifold to the sums of its two bodies. `remaining_s` dates an impact.
void record_impulses(RigidBody& body, const ContactManifold& manifold, ImpulseKind kind, double remaining_s);

}  // namespace livegs

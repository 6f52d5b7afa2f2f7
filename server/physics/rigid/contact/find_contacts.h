// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/collider.h"
#include "physics/rigid/rigid_body.h"

// Contact detection for rigid bodies and balls. Contacts are speculative: a surface within reach in the
// substep gets a constraint row that lets the gap close but not overlap, so thin bodies stop fast ones.

namespace livegs {

// Fills body.manifolds with the contacts possible within `duration_s` at the current velocity; the former
// manifolds become previous_manifolds. Partners are those in body.near (rigid_broad_phase.h). Contacts of
// sleeping bodies with sleeping or static ones are kept. Writes only `body`, so bodies may be processed in
// parallel.
void find_contacts(RigidBody& body, std::span<const Collider> colliders, double gravity_m_s2,
                   double duration_s);

}  // namespace livegs

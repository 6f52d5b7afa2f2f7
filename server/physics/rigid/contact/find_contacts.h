// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/collider.h"
#include "physics/rigid/rigid_body.h"

// Where rigid bodies and balls are about to touch within one substep. Contacts are speculative: what would be
// reached within the substep gets a row that lets it close the gap and no more, so that thin things stop fast
// ones.

namespace livegs {

// Fills body.manifolds for everything it may touch in the next `duration_s` at its present velocity; the
// former manifolds become previous_manifolds. Partners are those in body.near (rigid_broad_phase.h); what two
// sleepers lie on stays as it was. Writes only `body`, reads everything: bodies can be done in parallel.
void find_contacts(RigidBody& body, std::span<const Collider> colliders, double gravity_m_s2,
                   double duration_s);

}  // namespace livegs

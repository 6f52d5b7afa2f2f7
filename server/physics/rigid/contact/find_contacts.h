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

struct ContactCandidate;

// Fills body.manifolds with the contacts possible within `duration_s` at the current velocity; the former
// manifolds become previous_manifolds. Partners are those in body.near (rigid_broad_phase.h). Contacts of
// sleeping bodies with sleeping or static ones are kept. Writes only `body`, so bodies may be processed in
// parallel.
void find_contacts(RigidBody& body, std::span<const Collider> colliders, double gravity_m_s2,
                   double duration_s);

// contact_manifold.cpp.

// Reuses the previous substep's manifold, moved to the current poses, if the pair allows it and the relative
// motion since detection is below a thousandth of the size. Returns whether it did.
bool reuse_manifold(RigidBody& body, const ContactPair& pair);

// Groups candidates into manifolds of at most four points (the deepest, then the widest spread) and appends
// them to body.manifolds. Impulses of matching features in body.previous_manifolds are carried over. Sorts
// `candidates` in place.
void append_manifolds(RigidBody& body, const ContactPair& pair, std::vector<ContactCandidate>& candidates);

}  // namespace livegs

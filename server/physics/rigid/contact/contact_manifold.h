// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "physics/collision/contact_candidate.h"
#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/rigid_body.h"

namespace livegs {

// Properties shared by all contact points of a pair.
struct ContactPair {
  RigidBody* other = nullptr;
  uint64_t other_id = 0;
  double collider_friction = 0;  // without another body
  double restitution = 0;
  double restitution_speed_m_s = 0;
  double push_speed_m_s = 0;
  double size_m = 0;   // bounding radius of the smaller body
  bool lasts = false;  // two convex bodies: contacts are reusable while the pair does not move
};

// Reuses the previous substep's manifold, moved to the current poses, if the pair allows it and the relative
// motion since detection is below a thousandth of the size. Returns whether it did.
bool reuse_manifold(RigidBody& body, const ContactPair& pair);

// Groups candidates into manifolds of at most four points (the deepest, then the widest spread) and appends
// them to body.manifolds. Impulses of matching features in body.previous_manifolds are carried over. Sorts
// `candidates` in place.
void append_manifolds(RigidBody& body, const ContactPair& pair, std::vector<ContactCandidate>& candidates);

}  // namespace livegs

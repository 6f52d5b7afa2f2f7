// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "physics/collision/contact_candidate.h"
#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/rigid_body.h"

namespace livegs {

// What two touching things share, whatever the points.
struct ContactPair {
  RigidBody* other = nullptr;
  uint64_t other_id = 0;
  double friction = 0;
  double restitution = 0;
  double restitution_speed_m_s = 0;
  double push_speed_m_s = 0;
  double size_m = 0;   // bounding radius of the smaller one
  bool lasts = false;  // two convex bodies: the contacts stay good while the two lie still on each other
};

// Takes over the manifold of the substep before, at the bodies' present places, if it lasts and they have not
// moved against each other since it was found by more than a thousandth of the size.
bool reuse_manifold(RigidBody& body, const ContactPair& pair, double duration_s);

// Normals within 30 degrees of the deepest point's belong to one manifold.
inline constexpr double kManifoldNormalCosine = 0.866;

// Groups candidates into manifolds of at most four points (the deepest region first, then spread as wide as
// possible) and appends them to body.manifolds. Impulses of the same features in body.previous_manifolds are
// carried over. `candidates` is sorted in place.
void append_manifolds(RigidBody& body, const ContactPair& pair, double duration_s,
                      std::vector<ContactCandidate>& candidates);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/pose.h"
#include "physics/collider.h"
#include "physics/collision/contact_candidate.h"

// Contacts of a cylinder or capsule are found on its mesh, which has facets, and then moved to the exact
// surface, so that the body rolls. `round` is in the body frame.

namespace livegs {

// Moves the points of `candidates` to the exact surface of a body in `world_from_body` and joins those that
// coincide. The body is the first of the pair, or else the other one. Contacts with the flat ends of a
// cylinder, away from their lowest point, stay as they are.
enum class PairSide { First, Other };
void move_to_round_surface(const RoundShape& round, const Pose& world_from_body, PairSide side,
                           std::vector<ContactCandidate>& candidates);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"

// Shared by the contacts of a `cells` body with rigid bodies and with elastic bodies.

namespace livegs::cells {

// Relative motion, in particle edges, after which the contacts with a body are found again. Until then their
// material points and normals are kept. While nothing can touch, half of kElementReach: within it every point
// of the other surface has an element in reach.
inline constexpr double kCandidateMargin = 0.25;
// Minimum margin of the candidate search, in cell widths, for colliders and rigid bodies.
inline constexpr double kCandidateRoom = 0.5;
// Motion that is counted for a step over that at the speeds at its start. Smaller: a body that speeds up is
// found late. What it still lacks is counted in the next step.
inline constexpr double kMotionRoom = 1.5;
// Bound of the speeds of nodes relative to the rigid motion, over their root mean square. Smaller: light
// nodes that touch are found late. Larger: more searches.
inline constexpr double kNodeDeviations = 4.0;

inline uint64_t id_of(const RigidProxy* body) { return body->body_id; }
inline uint64_t id_of(const ElasticNeighbour& body) { return body.body_id; }

// Brings `contacts` into the order of `bodies`: those of other bodies go, new ones are empty. Returns whether
// they had it.
template <class Contacts, class Bodies>
bool keep_contacts(std::vector<Contacts>& contacts, const Bodies& bodies) {
  const auto same_id = [](const Contacts& one, const auto& body) { return one.body_id == id_of(body); };
  if (std::equal(contacts.begin(), contacts.end(), bodies.begin(), bodies.end(), same_id)) return true;
  std::vector<Contacts> kept(bodies.size());
  for (size_t k = 0; k < kept.size(); ++k) {
    const auto known = std::find_if(contacts.begin(), contacts.end(),
                                    [&](const Contacts& one) { return same_id(one, bodies[k]); });
    if (known != contacts.end()) kept[k] = std::move(*known);
    kept[k].body_id = id_of(bodies[k]);
  }
  contacts = std::move(kept);
  return false;
}

}  // namespace livegs::cells

// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/rigid_islands.h"

#include <algorithm>
#include <cstdint>
#include <functional>

#include "core/disjoint_sets.h"
#include "physics/rigid/joint/joint_group.h"

namespace livegs {

namespace {
// Free fall in a substep of 1/240 s, m. A sleeping body closer than this below an awake one is woken, because
// it may be supported by it. The two have to fall asleep together; otherwise they wake each other
// alternately.
constexpr double kNearlyTouching_m = 2.5e-4;
}  // namespace

bool is_touching(const ContactManifold& manifold) {
  return std::ranges::any_of(manifold.used(), [](const ContactPoint& point) {
    return point.impulse_n_s > 0.0 || point.separation_m <= kNearlyTouching_m;
  });
}

std::vector<RigidIsland> rigid_islands(std::span<RigidBody* const> bodies, IslandLink link,
                                       const Eigen::Vector3d& gravity_m_s2) {
  for (size_t i = 0; i < bodies.size(); ++i) bodies[i]->slot = static_cast<uint32_t>(i);
  DisjointSets sets(bodies.size());
  for (RigidBody* body : bodies) {
    if (body->asleep) continue;
    if (body->joints) sets.join(body->slot, body->joints->bodies().front()->slot);
    for (const ContactManifold& manifold : body->manifolds) {
      if (!manifold.other || manifold.other->asleep) continue;
      if (link == IslandLink::AnyManifold || is_touching(manifold))
        sets.join(body->slot, manifold.other->slot);
    }
  }
  // Roots are the smallest elements of their sets, so islands are in ascending id.
  std::vector<RigidIsland> islands;
  std::vector<uint32_t> island_of(bodies.size(), 0);
  for (RigidBody* body : bodies) {
    if (body->asleep) continue;
    const uint32_t root = sets.find(body->slot);
    if (root == body->slot) {
      island_of[root] = static_cast<uint32_t>(islands.size());
      islands.emplace_back();
    }
    islands[island_of[root]].bodies.push_back(body);
  }
  if (link == IslandLink::TouchingManifold) return islands;

  for (RigidBody* body : bodies) {
    if (!body->asleep) continue;
    for (ContactManifold& manifold : body->manifolds) {
      if (!manifold.other || manifold.other->asleep) continue;
      islands[island_of[sets.find(manifold.other->slot)]].contacts.push_back({body, &manifold});
    }
  }
  for (RigidIsland& island : islands) {
    std::ranges::stable_sort(island.bodies, std::greater(), [&](const RigidBody* body) {
      return gravity_m_s2.dot(body->world_from_body.position_m);
    });
    for (RigidBody* body : island.bodies) {
      for (ContactManifold& manifold : body->manifolds) island.contacts.push_back({body, &manifold});
    }
  }
  return islands;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "physics/rigid/rigid_body.h"

namespace livegs {

// Awake bodies that touch each other directly or through others, and all their contacts. Walls and sleepers
// do not join what they touch. Islands share nothing that is written, so that each is one thread's.
struct RigidIsland {
  struct Contact {
    RigidBody* owner;
    ContactManifold* manifold;
  };
  std::vector<RigidBody*> bodies;  // the lowest first, against gravity: sweeps go from the ground up
  std::vector<Contact> contacts;   // in the order of their owners
};

// The islands of `bodies` (ascending id), ordered by the lowest id in them. `manifolds_join`: every manifold,
// or those that touch only (for sleep). Sleeping owners' manifolds with awake bodies count too.
enum class IslandLink { AnyManifold, TouchingManifold };
std::vector<RigidIsland> rigid_islands(std::span<RigidBody* const> bodies, IslandLink link,
                                       const Eigen::Vector3d& gravity_m_s2);

// Pressed together, overlapping, or nearer than a body falls in a substep.
bool is_touching(const ContactManifold& manifold);

}  // namespace livegs

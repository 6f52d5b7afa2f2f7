// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "physics/rigid/rigid_body.h"

namespace livegs {

// Simulation island: awake bodies connected by contacts, and their contacts. Static and sleeping bodies do
// not connect islands. Islands share no mutable data, so each is solved by one thread.
struct RigidIsland {
  struct Contact {
    RigidBody* owner;
    ContactManifold* manifold;
  };
  std::vector<RigidBody*> bodies;  // from the ground up, so that sweeps start at the bottom
  std::vector<Contact> contacts;   // ordered by owner
};

// Islands of `bodies` (ascending id), ordered by their lowest id. `link` selects the manifolds that connect
// bodies: all, or only touching ones (for sleep). Manifolds of sleeping owners with awake bodies are
// included.
enum class IslandLink { AnyManifold, TouchingManifold };
std::vector<RigidIsland> rigid_islands(std::span<RigidBody* const> bodies, IslandLink link,
                                       const Eigen::Vector3d& gravity_m_s2);

// Whether the contact pushes, overlaps, or is closer than a body falls in one substep.
bool is_touching(const ContactManifold& manifold);

}  // namespace livegs

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

// Division of an island's substep (step_plan.cpp). Islands with joints plan their own steps. They, and
// islands with very many contacts, take one detection and the usual steps.
struct StepPlan {
  // Sub-intervals, each with its own contacts. More than 1 if two free, non-spherical bodies approach by
  // several times their thickness in a substep: a stopped corner then turns a body over within the substep,
  // and contacts found at its start miss the faces that arrive later.
  int detections = 1;
  // Solver steps of the substep. More than usual if a contact would sink visibly under the weight that it
  // carries, or a stack would buckle.
  int steps;
};

// Contact springs are as stiff as the step allows, so the sag under a weight grows with the square of the
// step. `duration_s`: of the substep, whose number is WorldSettings::substeps; `usual_steps`: the least
// number of solver steps.
StepPlan plan_steps(const RigidIsland& island, const Eigen::Vector3d& gravity_m_s2, double duration_s,
                    int usual_steps);

}  // namespace livegs

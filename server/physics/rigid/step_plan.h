// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/rigid_islands.h"

namespace livegs {

// Division of an island's substep. Islands with joints plan their own steps. They, and islands with very many
// contacts, take one detection and the usual steps.
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

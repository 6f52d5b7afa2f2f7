// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// Open Dynamics Engine's rigid bodies, as they come: error reduction 0.2, its least constraint force mixing,
// gyroscopic term on, double precision. One step of ODE a substep, with dWorldQuickStep (20 iterations) or,
// for RigidEngine::Ode, dWorldStep. Friction is its pyramid proportional to the normal force
// (dContactApprox1), up to eight contact points a pair. Its random order of rows starts from the same seed
// each time. One thread at a time in the process.
std::unique_ptr<RigidSolver> make_ode_rigid(const RigidSetup& setup, const RigidConditions& conditions);

}  // namespace livegs::study

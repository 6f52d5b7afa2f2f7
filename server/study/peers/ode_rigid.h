// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// Open Dynamics Engine's rigid bodies with default settings: error reduction 0.2, minimum constraint force
// mixing, gyroscopic term on, double precision. One step per substep, with dWorldQuickStep (20 iterations)
// or, for RigidEngine::Ode, dWorldStep. Friction is a pyramid proportional to the normal force
// (dContactApprox1), with up to eight contact points per pair. The random order of rows uses a fixed seed.
// One thread at a time in the process.
std::unique_ptr<RigidSolver> make_ode_rigid(const RigidSetup& setup, const RigidConditions& conditions);

}  // namespace livegs::study

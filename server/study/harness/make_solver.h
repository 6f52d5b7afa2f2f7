// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "study/harness/rigid_solver.h"
#include "study/harness/setup.h"

// Factories of all engines, LiveGS and peers. Only these files depend on all of them.

namespace livegs::study {

// Creates the body with the engine of the setup. An error with the reason if the engine does not support it.
Result<std::unique_ptr<ElasticBody>> make_study_body(const Setup& setup,
                                                     const ElasticBodyDescription& description);

// Creates the solver of the setup's engine. An error with the reason if the engine does not support the
// scene.
Result<std::unique_ptr<RigidSolver>> make_rigid_solver(const RigidSetup& setup,
                                                       const RigidConditions& conditions);

}  // namespace livegs::study

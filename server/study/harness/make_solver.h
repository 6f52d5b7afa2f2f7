// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "study/harness/rigid_solver.h"
#include "study/harness/setup.h"

// The solver of an engine, ours or a peer: the only files that know all of them.

namespace livegs::study {

// Fails where the engine cannot make the body, with its reason.
Result<std::unique_ptr<ElasticBody>> make_study_body(const Setup& setup,
                                                     const ElasticBodyDescription& description);

// Fails where the engine cannot run the scene, with its reason.
Result<std::unique_ptr<RigidSolver>> make_rigid_solver(const RigidSetup& setup,
                                                       const RigidConditions& conditions);

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "physics/elastic/resolution/lattice_resolution.h"

// One budget for all elastic bodies of a scene, in node-substeps a frame: nodes times substeps, summed. It is
// a nominal cost and no clock is read, so a scene gets the same cells on every machine.

namespace livegs {

inline constexpr double kNodeSubstep_ms = 26e-6;  // of one core; `elastic_bench` has what it takes

// The most that each body may cost so that all fit, the same for all: a body that asks for less keeps what it
// asks for, and what it leaves is the others'. Found from `budget` down in steps of a tenth; at least budget
// / bodies, also where bodies whose cells were given take more than their part. Infinite where all get what
// they ask for within the budget.
double fair_share(std::span<const ResolutionRequest> requests, double budget_node_substeps);

}  // namespace livegs

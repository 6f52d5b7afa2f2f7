// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include "physics/elastic/resolution/lattice_resolution.h"
#include "scene/build/build_object.h"

// A common budget for all elastic bodies of a scene, in node-substeps per frame (nodes times substeps,
// summed). The cost is nominal and independent of the clock, so a scene gets the same cells on every machine.

namespace livegs {

// Per-body cost cap such that the total fits the budget (max-min fair): bodies below the cap keep their
// request, and the remainder is redistributed. The search goes down from `budget_node_substeps` in steps of
// 10 %. The result is at least budget / bodies, even if bodies with given cells exceed their share. Infinite
// if all requests fit.
double fair_share(std::span<const ResolutionRequest> requests, double budget_node_substeps);

// Sets ElasticBodyDescription::max_node_substeps of each elastic body to its share of the world's budget.
// Precondition: all results are successes.
void share_elastic_budget(std::span<std::optional<Result<BuiltObject>>> built, const WorldSettings& settings);

}  // namespace livegs

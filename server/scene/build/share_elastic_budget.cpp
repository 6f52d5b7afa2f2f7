// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/share_elastic_budget.h"

#include <algorithm>
#include <vector>

#include "core/log.h"
#include "physics/elastic/resolution/elastic_budget.h"
#include "physics/elastic/resolution/resolution_request.h"

namespace livegs {

void share_elastic_budget(std::span<std::optional<Result<BuiltObject>>> built,
                          const WorldSettings& settings) {
  if (settings.elastic_solver != ElasticSolver::Cells) return;
  const double budget = settings.elastic_node_substeps;
  std::vector<ElasticBodyDescription*> bodies;
  std::vector<ResolutionRequest> requests;
  for (auto& object : built) {
    auto* elastic = std::get_if<ElasticBodyDescription>(&(**object).body);
    if (!elastic || !check_elastic_body(*elastic)) continue;  // World::add_elastic reports the error
    bodies.push_back(elastic);
    requests.push_back(resolution_request(*elastic, settings.rate_hz, settings.substeps));
    requests.back().max_node_substeps = elastic->own_budget ? elastic->max_node_substeps : budget;
  }
  const double share = std::min(budget, fair_share(requests, budget));
  for (ElasticBodyDescription* body : bodies) {
    if (!body->own_budget) body->max_node_substeps = share;
    body->scene_node_substeps = body->own_budget ? body->max_node_substeps : budget;
  }
  if (share == budget) return;
  log_warn(
      "elastic budget: %.3g ms a tick leaves %.3g ms for each of %zu elastic objects, so some have wider "
      "cells or less stiffness; use fewer or smaller ones, or raise elastic_budget_ms",
      kNodeSubstep_ms * budget, kNodeSubstep_ms * share, bodies.size());
}

}  // namespace livegs

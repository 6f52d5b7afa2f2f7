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
    if (!elastic || !check_elastic_body(*elastic)) continue;  // the world says what is wrong with it
    bodies.push_back(elastic);
    requests.push_back(resolution_request(*elastic, settings.rate_hz, settings.substeps));
    requests.back().max_node_substeps = budget;
  }
  const double share = std::min(budget, fair_share(requests, budget));
  for (ElasticBodyDescription* body : bodies) {
    body->max_node_substeps = share;
    body->scene_node_substeps = budget;
  }
  if (share == budget) return;
  log_warn(
      "the elastic budget, %.3g ms a tick, does for %.3g ms of each of %zu elastic objects: some get wider "
      "cells or are less "
      "stiff than alone. Fewer or smaller ones, or a larger elastic_budget_ms, give them more",
      kNodeSubstep_ms * budget, kNodeSubstep_ms * share, bodies.size());
}

}  // namespace livegs

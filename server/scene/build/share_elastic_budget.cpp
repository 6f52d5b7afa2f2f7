// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/share_elastic_budget.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "core/log.h"

namespace livegs {
namespace {

double cost_of_all(std::span<const ResolutionRequest> requests, double share) {
  double sum = 0.0;
  for (ResolutionRequest request : requests) {
    if (request.cell_width_m <= 0.0) request.max_node_substeps = std::min(request.max_node_substeps, share);
    sum += choose_resolution(request).node_substeps;
  }
  return sum;
}

}  // namespace

double fair_share(std::span<const ResolutionRequest> requests, double budget_node_substeps) {
  const double whole = std::numeric_limits<double>::infinity();
  if (requests.empty() || cost_of_all(requests, whole) <= budget_node_substeps) return whole;
  const double equal = budget_node_substeps / static_cast<double>(requests.size());
  double share = budget_node_substeps;
  while (share > equal && cost_of_all(requests, share) > budget_node_substeps) share *= 0.9;
  return std::max(share, equal);
}

void share_elastic_budget(std::span<std::optional<Result<BuiltObject>>> built,
                          const WorldSettings& settings) {
  if (settings.make_elastic != make_elastic_body) return;
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

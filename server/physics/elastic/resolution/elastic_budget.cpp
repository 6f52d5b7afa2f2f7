// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/resolution/elastic_budget.h"

#include <algorithm>
#include <limits>

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

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/resolution/elastic_budget.h"

#include <algorithm>
#include <limits>

namespace livegs {
namespace {

double cost_of_all(std::span<const CellDemand> demands, double share) {
  double sum = 0.0;
  for (CellDemand demand : demands) {
    if (demand.cell_width_m <= 0.0) demand.most_node_substeps = std::min(demand.most_node_substeps, share);
    sum += choose_cells(demand).node_substeps;
  }
  return sum;
}

}  // namespace

double fair_share(std::span<const CellDemand> demands, double budget_node_substeps) {
  constexpr double kStep = 0.9;
  const double whole = std::numeric_limits<double>::infinity();
  if (demands.empty() || cost_of_all(demands, whole) <= budget_node_substeps) return whole;
  const double equal = budget_node_substeps / static_cast<double>(demands.size());
  double share = budget_node_substeps;
  while (share > equal && cost_of_all(demands, share) > budget_node_substeps) share *= kStep;
  return std::max(share, equal);
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>

#include "study/chart/chart_row.h"
#include "study/chart/chart_scenes.h"

namespace livegs::study {

struct ChartPlan {
  std::string only;    // name of a scene; empty: all
  bool quick = false;  // fewer substeps, moduli and widths: seconds instead of minutes
};

// The runs of all curves, and of the table of values chosen by the program at 4 requested substeps.
// Deterministic for a plan.
struct PlannedRun {
  const ChartScene* scene = nullptr;
  std::string variant;
  Setup setup;
};
std::vector<PlannedRun> plan_runs(const ChartPlan& plan);

// Runs on all threads; rows are in the order of the plan, and unsupported runs are left out. `progress` is
// called with the number of finished runs and the total, from any thread, one call at a time.
std::vector<ChartRow> run_all(const std::vector<PlannedRun>& runs,
                              const std::function<void(size_t done, size_t of, const PlannedRun&)>& progress);

}  // namespace livegs::study

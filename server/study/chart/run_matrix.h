// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>

#include "study/chart/chart_row.h"
#include "study/chart/chart_scenes.h"

namespace livegs::study {

struct ChartPlan {
  std::string only;    // a scene's name, or empty for all
  bool quick = false;  // fewer substeps, moduli and widths: seconds instead of minutes
};

// The runs of the scenes' curves, and of the table of what the program chooses by itself at the scene's 4
// substeps. Always the same for the same plan.
struct PlannedRun {
  const ChartScene* scene = nullptr;
  std::string variant;
  Setup setup;
};
std::vector<PlannedRun> plan_runs(const ChartPlan& plan);

// Runs them on all threads and gives rows in the order of the plan; what an engine cannot run is left out.
// `progress` is called with what is done and the whole, from any thread, one call at a time.
std::vector<ChartRow> run_all(const std::vector<PlannedRun>& runs,
                              const std::function<void(size_t done, size_t of, const PlannedRun&)>& progress);

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "study/chart/chart_figure.h"
#include "study/chart/run_matrix.h"
#include "study/harness/rigid_setup.h"

// The rigid scenes on the chart: over substeps, ours beside Bullet's and ODE's, in one process and on one
// thread.

namespace livegs::study {

struct RigidChartScene {
  std::string name;  // "incline"; files are named after it
  std::string title;
  std::string what;      // for the page: bodies, what is measured
  std::string settings;  // on the figure
  Result<RigidOutcome> (*run)(const RigidSetup&);
  std::vector<std::string> quantities;  // measurements that are drawn, a panel each
  std::vector<double> parameters{0.0};  // and for each of these
  std::string parameter_text{};  // "1:%g", or words for each of them, a bar between: "flat|on a corner"
  int max_exact_substeps =
      32;  // of ODE's exact solver, whose cost goes with the cube of contacts; 0: not run
  std::vector<int> quick_substeps{1, 2, 4, 8, 16, 32};

  std::string text_of(double parameter) const;
  std::string figure() const { return "rigid_" + name + ".svg"; }
};

std::span<const RigidChartScene> rigid_chart_scenes();

struct RigidRow {
  const RigidChartScene* scene = nullptr;
  RigidSetup setup;
  RigidOutcome outcome;
};

// Runs them one after the other on the calling thread; what an engine cannot run is left out. `progress` is
// called before each run with what is done and the whole. Call set_thread_count(1) first, so that costs are
// of one core.
std::vector<RigidRow> run_rigid_scenes(
    const ChartPlan& plan,
    const std::function<void(size_t done, size_t of, const RigidChartScene&, const RigidSetup&)>& progress);

// A panel a quantity and parameter, curves in the order they were run.
std::vector<Panel> rigid_panels(const RigidChartScene& scene, const std::vector<RigidRow>& rows);
Figure rigid_figure(const RigidChartScene& scene, const std::vector<RigidRow>& rows);

// Lines below chart_csv's header; what is elastic alone stays empty.
std::string rigid_csv(const std::vector<RigidRow>& rows);
// The page's section, empty without rows.
std::string rigid_page(const std::vector<RigidRow>& rows);

}  // namespace livegs::study

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

// The rigid scenes of the chart: LiveGS, Bullet and ODE over substeps, in one process and on one thread.

namespace livegs::study {

struct RigidChartScene {
  std::string name;  // "incline"; also the file name
  std::string title;
  std::string what;      // for the page: bodies and figures
  std::string settings;  // printed on the figure
  Result<RigidOutcome> (*run)(const RigidSetup&);
  std::vector<std::string> quantities;  // drawn measurements, one panel each
  std::vector<double> parameters{0.0};  // each measurement is drawn for each of these
  std::string parameter_text{};  // "1:%g", or one text per parameter, separated by bars: "flat|on a corner"
  int max_exact_substeps = 32;   // limit of ODE's exact solver, whose cost is cubic in contacts; 0: not run
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

// Runs the scenes in order on the calling thread; unsupported runs are left out. `progress` is called before
// each run with the number of finished runs and the total. Call set_thread_count(1) first, so that costs are
// for one core.
std::vector<RigidRow> run_rigid_scenes(
    const ChartPlan& plan,
    const std::function<void(size_t done, size_t of, const RigidChartScene&, const RigidSetup&)>& progress);

// One panel per quantity and parameter, curves in run order.
std::vector<Panel> rigid_panels(const RigidChartScene& scene, const std::vector<RigidRow>& rows);
Figure rigid_figure(const RigidChartScene& scene, const std::vector<RigidRow>& rows);

// Lines for chart_csv; elastic columns stay empty.
std::string rigid_csv(const std::vector<RigidRow>& rows);
// The section of the page; empty without rows.
std::string rigid_page(const std::vector<RigidRow>& rows);

}  // namespace livegs::study

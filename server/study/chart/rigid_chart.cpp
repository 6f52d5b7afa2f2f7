// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/rigid_chart.h"

#include <algorithm>

#include "core/text/format_text.h"
#include "study/chart/chart_words.h"

namespace livegs::study {
namespace {

struct PlannedRigid {
  const RigidChartScene* scene;
  RigidSetup setup;
};

std::vector<PlannedRigid> plan_rigid(const ChartPlan& plan) {
  std::vector<PlannedRigid> runs;
  for (const RigidChartScene& scene : rigid_chart_scenes()) {
    if (!plan.only.empty() && scene.name != plan.only) continue;
    const std::vector<int> substeps =
        plan.quick ? scene.quick_substeps : std::vector<int>{1, 2, 4, 8, 16, 32};
    for (const double parameter : scene.parameters) {
      for (const RigidEngine engine :
           {RigidEngine::Livegs, RigidEngine::Bullet, RigidEngine::OdeQuick, RigidEngine::Ode}) {
        for (const int n : substeps) {
          if (engine == RigidEngine::Ode && n > scene.max_exact_substeps) break;
          runs.push_back({&scene, {.engine = engine, .substeps = n, .parameter = parameter}});
        }
      }
    }
  }
  return runs;
}

}  // namespace

std::vector<RigidRow> run_rigid_scenes(
    const ChartPlan& plan,
    const std::function<void(size_t, size_t, const RigidChartScene&, const RigidSetup&)>& progress) {
  std::vector<RigidRow> rows;
  const std::vector<PlannedRigid> runs = plan_rigid(plan);
  for (size_t i = 0; i < runs.size(); ++i) {
    progress(i, runs.size(), *runs[i].scene, runs[i].setup);
    if (auto outcome = runs[i].scene->run(runs[i].setup))
      rows.push_back({runs[i].scene, runs[i].setup, *outcome});
  }
  return rows;
}

std::string RigidChartScene::text_of(double parameter) const {
  if (parameter_text.find('|') == std::string::npos) return format_text(parameter_text.c_str(), parameter);
  const auto index = std::find(parameters.begin(), parameters.end(), parameter) - parameters.begin();
  size_t begin = 0;
  for (std::ptrdiff_t i = 0; i < index; ++i) begin = parameter_text.find('|', begin) + 1;
  return parameter_text.substr(begin, parameter_text.find('|', begin) - begin);
}

std::vector<Panel> rigid_panels(const RigidChartScene& scene, const std::vector<RigidRow>& rows) {
  std::vector<Panel> panels;
  for (const double parameter : scene.parameters) {
    for (const std::string& quantity : scene.quantities) {
      Panel panel;
      panel.quantity = quantity;
      panel.name = panel.title = quantity;
      for (char& c : panel.title) c = c == '_' ? ' ' : c;
      if (scene.parameters.size() > 1) {
        panel.name += ", " + scene.text_of(parameter);
        panel.title += ", " + scene.text_of(parameter);
      }
      for (const RigidRow& row : rows) {
        if (row.scene != &scene || row.setup.parameter != parameter) continue;
        const Measurement& m = row.outcome[quantity];
        panel.unit = m.unit;
        panel.bar = m.bar;
        const std::string label = engine_name(row.setup.engine);
        if (panel.curves.empty() || panel.curves.back().label != label) panel.curves.push_back({label, {}});
        panel.curves.back().points.push_back(
            {row.setup.substeps, 1e-6 * row.outcome.cost.cpu_ns_per_simulated_s(), m.error});
      }
      if (!panel.curves.empty()) panels.push_back(std::move(panel));
    }
  }
  return panels;
}

Figure rigid_figure(const RigidChartScene& scene, const std::vector<RigidRow>& rows) {
  return {scene.title, scene.settings, rigid_panels(scene, rows), false,
          "60 Hz, 1 to 32 substeps per frame, numbered on livegs. Upper edge: fell, exploded or did not "
          "happen; lower: less"};
}

std::string rigid_csv(const std::vector<RigidRow>& rows) {
  std::string lines;
  for (const RigidRow& row : rows) {
    const Cost& cost = row.outcome.cost;
    const double work = static_cast<double>(row.outcome.bodies) * static_cast<double>(cost.substeps);
    for (const Measurement& m : row.outcome.measurements) {
      lines += format_text(
          "%s,%s,none,cpu,%s,%g,%d,%zu,0,%zu,%.2f,%.4f,%.6g,%s,%g,", row.scene->name.c_str(),
          engine_name(row.setup.engine).c_str(), row.setup.engine == RigidEngine::Bullet ? "float" : "double",
          row.setup.rate_hz, row.setup.substeps, row.outcome.bodies, row.outcome.bodies,
          work > 0.0 ? 1e9 * cost.cpu_s / work : 0.0, cost.wall_s, m.error, m.unit.c_str(), m.bar);
      lines += format_text("%s,%.9g,%.9g,%s,,,,,%d,,,,,,%.6g,%.6g,%.6g,%d,%g,%s\n", m.quantity.c_str(),
                           m.measured, m.reference, "rigid", row.setup.substeps, cost.simulated_s, cost.cpu_s,
                           cost.cpu_ns_per_simulated_s(), row.outcome.end == RunEnd::NonFinite ? 0 : 1,
                           row.setup.parameter, name_of(row.outcome.end));
    }
  }
  return lines;
}

}  // namespace livegs::study

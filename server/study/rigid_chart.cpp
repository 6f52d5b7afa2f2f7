// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/rigid_chart.h"

#include "study/chart_words.h"
#include "study/rigid_scenes.h"

namespace livegs::study {

std::span<const RigidChartScene> rigid_chart_scenes() {
  static const std::vector<RigidChartScene> scenes = {
      {.name = "incline",
       .title = "Slab on a slope",
       .what = "A slab of 0.2 x 0.05 x 0.2 m on a plane, friction 0.1, 0.3, 0.5, 0.7 and 1, the worst of the five: between "
               "the angle at which it starts to slide (found to 0.003 degrees) and atan(mu); how far it creeps in 10 s one degree below; its "
               "acceleration ten degrees above against g (sin - mu cos).",
       .settings = "0.2 x 0.05 x 0.2 m, mu 0.1 to 1",
       .run = incline,
       .quantities = {"threshold", "creep", "acceleration"}},
      {.name = "stopping",
       .title = "Stopping distance",
       .what = "The slab slides off at 2 m/s along x and along the diagonal, friction 0.2, 0.4 and 0.7, the worst of the "
               "six: its way against v^2 / (2 mu g), and how fast it still moves once it has stopped.",
       .settings = "2 m/s, mu 0.2, 0.4, 0.7, along x and the diagonal",
       .run = stopping,
       .quantities = {"distance", "drift"}},
      {.name = "rolling_box",
       .title = "Pushed box under 25 balls",
       .what = "150 N push a box of 10 kg, with 25 balls of 1 kg on it, over a floor of friction 0.4: its speed after 1 s "
               "against the closed form, the worst of x, z and the diagonal, and how much the three differ. The push is 9 % "
               "more than the floor's friction, so one per cent of friction is eleven of speed.",
       .settings = "10 kg, 150 N, 25 balls of 1 kg, mu 0.4 below and 0.8 above",
       .run = rolling_box,
       .quantities = {"speed", "isotropy"},
       .most_exact_substeps = 4},
      {.name = "tumbling",
       .title = "Dzhanibekov's tumbling",
       .what = "A free body with moments 1, 2, 3 kg m^2 turns at 10 rad/s about the middle one, 60 s: the farthest that energy "
               "and angular momentum stray, and the time of the first turn-over against Runge and Kutta's at 0.1 ms.",
       .settings = "moments 1, 2, 3 kg m^2, spin (0.01, 10, 0.01) rad/s, 60 s",
       .run = tumbling,
       .quantities = {"energy", "momentum", "flip_time"},
       .most_exact_substeps = 0},
  };
  return scenes;
}

namespace {

struct PlannedRigid {
  const RigidChartScene* scene;
  RigidSetup setup;
};

std::vector<PlannedRigid> plan_rigid(const ChartPlan& plan) {
  std::vector<PlannedRigid> runs;
  for (const RigidChartScene& scene : rigid_chart_scenes()) {
    if (!plan.only.empty() && scene.name != plan.only) continue;
    const std::vector<int> substeps = plan.quick ? scene.quick_substeps : std::vector<int>{1, 2, 4, 8, 16, 32};
    for (const double parameter : scene.parameters) {
      for (const RigidEngine engine :
           {RigidEngine::Livegs, RigidEngine::Bullet, RigidEngine::OdeQuick, RigidEngine::Ode}) {
        for (const int n : substeps) {
          if (engine == RigidEngine::Ode && n > scene.most_exact_substeps) break;
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
    if (auto outcome = runs[i].scene->run(runs[i].setup)) rows.push_back({runs[i].scene, runs[i].setup, *outcome});
  }
  return rows;
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
        char value[64];
        std::snprintf(value, sizeof value, scene.parameter_text.c_str(), parameter);
        panel.name += std::string(", ") + value;
        panel.title += std::string(", ") + value;
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
  return {scene.title,
          scene.settings + "; 60 Hz, 1 to 32 substeps a frame, numbered on ours. On the upper edge: fell, flew apart or "
                           "never happened; on the lower: less",
          rigid_panels(scene, rows), false};
}

std::string rigid_csv(const std::vector<RigidRow>& rows) {
  std::string lines;
  for (const RigidRow& row : rows) {
    const Cost& cost = row.outcome.cost;
    const double work = static_cast<double>(row.outcome.bodies) * static_cast<double>(cost.substeps);
    for (const Measurement& m : row.outcome.measurements) {
      lines += text("%s,%s,none,cpu,%s,%g,%d,%zu,0,%zu,%.2f,%.4f,%.6g,%s,%g,", row.scene->name.c_str(),
                    engine_name(row.setup.engine).c_str(),
                    row.setup.engine == RigidEngine::Bullet ? "float" : "double", row.setup.rate_hz, row.setup.substeps,
                    row.outcome.bodies, row.outcome.bodies, work > 0.0 ? 1e9 * cost.cpu_s / work : 0.0, cost.wall_s,
                    m.error, m.unit.c_str(), m.bar);
      lines += text("%s,%.9g,%.9g,%s,,,,,%d,,,,,,%.6g,%.6g,%.6g,%d,%g,%s\n", m.quantity.c_str(), m.measured, m.reference,
                    "rigid", row.setup.substeps, cost.simulated_s, cost.cpu_s, cost.cpu_ns_per_simulated_s(),
                    row.outcome.end == RunEnd::NotANumber ? 0 : 1, row.setup.parameter, name_of(row.outcome.end));
    }
  }
  return lines;
}

namespace {

// Which runs did not come through, by engine.
std::string accidents(const RigidChartScene& scene, const std::vector<RigidRow>& rows) {
  std::string words;
  for (const RigidRow& row : rows) {
    if (row.scene != &scene || row.outcome.end == RunEnd::Well) continue;
    words += words.empty() ? "- Did not come through: " : ", ";
    words += text("`%s` at %d", engine_name(row.setup.engine).c_str(), row.setup.substeps);
    if (scene.parameters.size() > 1) words += " with " + text(scene.parameter_text.c_str(), row.setup.parameter);
    words += text(" (%s)", name_of(row.outcome.end));
  }
  return words.empty() ? words : words + ".\n";
}

}  // namespace

std::string rigid_page(const std::vector<RigidRow>& rows) {
  if (rows.empty()) return "";
  std::string page =
      "# Rigid bodies\n\nThe same scenes for ours (`livegs`), Bullet 3 (`bullet`: sequential impulse, 10 iterations, single "
      "precision) and the Open Dynamics Engine (`ode quick`: over-relaxation, 20 iterations; `ode`: its exact "
      "complementarity solver, where that can be paid), one after the other on one thread of this process, at 60 Hz. A "
      "substep is one step of the peer, of the same length; each does its own iterations in it. Same shapes, masses, "
      "inertias and frictions; no restitution, no damping, no sleep but where it is measured; margins and error reduction as "
      "the engines come. Bullet makes three contact points with a plane at once, as its makers advise.\n\n";
  for (const RigidChartScene& scene : rigid_chart_scenes()) {
    const std::vector<Panel> panels = rigid_panels(scene, rows);
    if (panels.empty()) continue;
    page += "## " + scene.title + "\n\n" + scene.what + "\n\n![" + scene.title + "](" + scene.figure() + ")\n\n";
    for (const Panel& panel : panels) {
      Panel named = panel;
      named.name += ", bar " + error_text(panel.bar, panel.unit);
      page += who_wins(named);
    }
    page += accidents(scene, rows) + "\n";
  }
  return page;
}

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/text/format_text.h"
#include "study/chart/chart_words.h"
#include "study/chart/rigid_chart.h"

namespace livegs::study {
namespace {

// Lists the failed runs by engine.
std::string failed_runs(const RigidChartScene& scene, const std::vector<RigidRow>& rows) {
  std::string words;
  for (const RigidRow& row : rows) {
    if (row.scene != &scene || row.outcome.end == RunEnd::Ok) continue;
    words += words.empty() ? "Failed runs: " : ", ";
    words += format_text("`%s` at %d", engine_name(row.setup.engine).c_str(), row.setup.substeps);
    if (scene.parameters.size() > 1) words += " with " + scene.text_of(row.setup.parameter);
    words += format_text(" (%s)", name_of(row.outcome.end));
  }
  return words.empty() ? words : words + ".\n\n";
}

}  // namespace

std::string rigid_page(const std::vector<RigidRow>& rows) {
  if (rows.empty()) return "";
  std::string page =
      "# Rigid bodies\n\nThe same scenes with LiveGS (`livegs`), Bullet 3 (`bullet`: sequential impulse, "
      "10 iterations, single precision) and the Open Dynamics Engine (`ode quick`: over-relaxation, 20 "
      "iterations; `ode`: its exact complementarity solver, where the cost permits). They run one after "
      "the other on one thread of this process at 60 Hz. A substep is one step of the peer of the same "
      "length, with the peer's own iterations. Shapes, masses, inertias and frictions are equal. There is "
      "no restitution, no damping, and no sleep except where it is measured. Margins and error reduction "
      "are the defaults of the engines. Bullet creates three contact points with a plane at once, as its "
      "documentation recommends.\n\n";
  for (const RigidChartScene& scene : rigid_chart_scenes()) {
    const std::vector<Panel> panels = rigid_panels(scene, rows);
    if (panels.empty()) continue;
    page +=
        "## " + scene.title + "\n\n" + scene.what + "\n\n![" + scene.title + "](" + scene.figure() + ")\n\n";
    std::vector<Panel> named = panels;
    for (Panel& panel : named) panel.name += ", bar " + error_text(panel.bar, panel.unit);
    page += compare_curves(named) + "\n" + failed_runs(scene, rows);
  }
  return page;
}

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/chart_words.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text/format_text.h"

namespace livegs::study {

std::string error_text(double error, const std::string& unit) {
  if (!std::isfinite(error)) return "no finite result";
  if (unit != "relative" && unit != "absolute") return format_text("%.2g %s", error, unit.c_str());
  if (error > 10) return format_text("a factor of %.2g", 1 + error);
  return format_text("%.2g %%", 100 * error);
}

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

namespace {

std::string cost(double ms) { return ms < 100 ? format_text("%.2g ms", ms) : format_text("%.0f ms", ms); }

struct Contender {
  const Curve* curve;
  CurvePoint point;
};

// Curves within the bar, cheapest first; ties keep their order.
std::vector<Contender> ranking(const Panel& panel) {
  std::vector<Contender> contenders;
  for (const Curve& curve : panel.curves) {
    if (const auto point = curve.cheapest_within(panel.bar)) contenders.push_back({&curve, *point});
  }
  std::stable_sort(contenders.begin(), contenders.end(),
                   [](const Contender& a, const Contender& b) { return a.point.cost_ms < b.point.cost_ms; });
  return contenders;
}

}  // namespace

std::string compare_curves(const std::vector<Panel>& panels) {
  std::string table =
      "| case | method | substeps | error | CPU per simulated second | cost over the cheapest "
      "|\n|---|---|---|---|---|---|\n";
  for (const Panel& panel : panels) {
    const std::vector<Contender> ranked = ranking(panel);
    std::string name = panel.name;  // in the first row of the case only
    const auto row = [&](const std::string& method, const CurvePoint& point, const std::string& ratio) {
      table += format_text("| %s | %s | %d | %s | %s | %s |\n", std::exchange(name, "").c_str(),
                           method.c_str(), point.substeps, error_text(point.error, panel.unit).c_str(),
                           cost(point.cost_ms).c_str(), ratio.c_str());
    };
    for (const Contender& each : ranked)
      row("`" + each.curve->label + "`", each.point,
          format_text("%.2g", each.point.cost_ms / ranked.front().point.cost_ms));
    for (const Curve& curve : panel.curves)
      if (!curve.cheapest_within(panel.bar)) row("`" + curve.label + "`", curve.best(), "not within the bar");
    if (panel.chosen) {
      const ElasticAccuracy& a = panel.chosen_accuracy;
      row(format_text("chosen by the program: %.3g mm", 1e3 * a.cell_width_m),
          {a.substeps, panel.chosen->cost_ms, panel.chosen->error}, a.clipped ? "stiffness clipped" : "");
    }
  }
  return table;
}

}  // namespace livegs::study

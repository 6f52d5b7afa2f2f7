// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/chart_words.h"

#include <algorithm>
#include <cmath>

#include "core/text/format_text.h"

namespace livegs::study {

std::string error_text(double error, const std::string& unit) {
  if (!std::isfinite(error)) return "no finite result";
  if (unit != "relative" && unit != "absolute") return format_text("%.2g %s", error, unit.c_str());
  if (error > 10) return format_text("a factor of %.2g", 1 + error);
  return format_text("%.2g %%", 100 * error);
}

namespace {

std::string cost(double ms) { return ms < 100 ? format_text("%.2g ms", ms) : format_text("%.0f ms", ms); }

// Cost ratio below which costs are equal within measurement noise.
constexpr double kSameCost = 1.15;

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

std::string compare_curves(const Panel& panel) {
  const std::vector<Contender> ranked = ranking(panel);
  std::string words = "- **" + panel.name + ".** ";
  if (ranked.empty()) {
    words += "No method meets the bar. ";
  } else {
    const Contender& first = ranked.front();
    words += format_text("Cheapest: `%s` at %d substeps, %s of CPU per simulated second (error %s)",
                         first.curve->label.c_str(), first.point.substeps, cost(first.point.cost_ms).c_str(),
                         error_text(first.point.error, panel.unit).c_str());
    for (size_t i = 1; i < ranked.size(); ++i) {
      const double times = ranked[i].point.cost_ms / first.point.cost_ms;
      words += format_text(
          "%s `%s` at %d, %s", i == 1 ? "; then" : ",", ranked[i].curve->label.c_str(),
          ranked[i].point.substeps,
          times < kSameCost ? "the same cost" : format_text("%.2g times the cost", times).c_str());
    }
    words += ". ";
  }
  std::string losers;
  for (const Curve& curve : panel.curves) {
    if (curve.cheapest_within(panel.bar)) continue;
    const CurvePoint best = curve.best();
    losers += format_text("%s `%s` (best: %s at %d)", losers.empty() ? "" : ",", curve.label.c_str(),
                          error_text(best.error, panel.unit).c_str(), best.substeps);
  }
  if (!losers.empty()) words += "Not within the bar in these runs:" + losers + ". ";
  if (panel.chosen) {
    const ElasticAccuracy& a = panel.chosen_accuracy;
    words += format_text(
        "With 4 requested substeps the program chooses %.3g mm cells and %d substeps: error %s for %s%s.",
        1e3 * a.cell_width_m, a.substeps, error_text(panel.chosen->error, panel.unit).c_str(),
        cost(panel.chosen->cost_ms).c_str(), a.clipped ? ", and reports clipped stiffness" : "");
  }
  return words + "\n";
}

}  // namespace livegs::study

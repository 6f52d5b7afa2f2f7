// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/chart_curves.h"

#include <cmath>
#include <cstdio>

namespace livegs::study {
namespace {

CurvePoint point_of(const ChartRow& row, const std::string& quantity) {
  return {row.outcome.accuracy.substeps, 1e-6 * row.outcome.cost.cpu_ns_per_simulated_s(),
          row.outcome[quantity].error};
}

}  // namespace

std::optional<CurvePoint> Curve::cheapest_within(double bar) const {
  std::optional<CurvePoint> cheapest;
  for (const CurvePoint& point : points) {
    if (point.error <= bar && (!cheapest || point.cost_ms < cheapest->cost_ms)) cheapest = point;
  }
  return cheapest;
}

CurvePoint Curve::best() const {
  CurvePoint best = points.front();
  for (const CurvePoint& point : points) {
    if (point.error < best.error) best = point;
  }
  return best;
}

std::string curve_label(const ChartRow& row) {
  std::string label = solver_name(row.setup);
  if (row.setup.engine == Engine::Cells || row.setup.engine == Engine::Bullet) {
    char width[32];
    std::snprintf(width, sizeof width, ", %g mm", 1e3 * row.setup.cell_width_m);
    label += width;
  }
  return label;
}

std::vector<Panel> panels_of(const ChartScene& scene, const std::string& quantity,
                             const std::vector<ChartRow>& rows) {
  std::vector<Panel> panels;
  for (const double modulus : scene.youngs_moduli_pa) {
    Panel panel;
    char name[48], title[48];
    std::snprintf(name, sizeof name, "%.0e Pa", modulus);
    std::snprintf(title, sizeof title, "E = 10^{%d} Pa", static_cast<int>(std::lround(std::log10(modulus))));
    panel.name = name;
    panel.title = title;
    for (const ChartRow& row : rows) {
      if (row.scene != scene.name || row.setup.youngs_modulus_pa != modulus || row.variant == "table")
        continue;
      panel.bar = row.outcome[quantity].bar;
      panel.quantity = quantity;
      panel.unit = row.outcome[quantity].unit;
      if (row.variant == "chosen") {
        panel.chosen = point_of(row, quantity);
        panel.chosen_accuracy = row.outcome.accuracy;
        continue;
      }
      const std::string label = curve_label(row);
      if (panel.curves.empty() || panel.curves.back().label != label) panel.curves.push_back({label, {}});
      panel.curves.back().points.push_back(point_of(row, quantity));
    }
    if (!panel.curves.empty()) panels.push_back(std::move(panel));
  }
  return panels;
}

}  // namespace livegs::study

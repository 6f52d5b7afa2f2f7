// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/chart/chart_row.h"
#include "study/chart/chart_scenes.h"

namespace livegs::study {

struct CurvePoint {
  int substeps = 0;      // per frame
  double cost_ms = 0.0;  // processor time per simulated second
  double error = 0.0;    // infinite if the run diverged
};

// One method over substeps, ascending.
struct Curve {
  std::string label;  // "cells, 25 mm"
  std::vector<CurvePoint> points;

  // The cheapest point within the bar; empty if there is none.
  std::optional<CurvePoint> cheapest_within(double bar) const;
  CurvePoint best() const;  // smallest error
};

// One panel of a figure; panels are side by side.
struct Panel {
  std::string name;   // name on the page: "1e+05 Pa"
  std::string title;  // above the panel, in gnuplot's enhanced text: "E = 10^{5} Pa"
  std::string quantity;
  std::string unit;  // unit of errors: "relative" and "absolute" are shown in percent
  double bar = 0.0;
  std::vector<Curve> curves;
  std::optional<CurvePoint> chosen;  // the cells and substeps chosen by the program
  ElasticAccuracy chosen_accuracy;
};

// One panel per modulus, curves in run order. Precondition: the scene measures `quantity`.
std::vector<Panel> panels_of(const ChartScene& scene, const std::string& quantity,
                             const std::vector<ChartRow>& rows);

// "cells, 25 mm"; methods without cells have no width.
std::string curve_label(const ChartRow& row);

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/chart/chart_row.h"
#include "study/chart/chart_scenes.h"

namespace livegs::study {

struct CurvePoint {
  int substeps = 0;      // a frame
  double cost_ms = 0.0;  // of processor time a simulated second
  double error = 0.0;    // infinite when the run did not stay finite
};

// One method over substeps, from few to many.
struct Curve {
  std::string label;  // "cells, 25 mm"
  std::vector<CurvePoint> points;

  // The cheapest point within the bar; nothing where there is none.
  std::optional<CurvePoint> cheapest_within(double bar) const;
  CurvePoint best() const;  // smallest error
};

// A figure is several panels side by side, or one.
struct Panel {
  std::string name;   // for the page: "1e+05 Pa"
  std::string title;  // above the panel, gnuplot's enhanced text: "E = 10^{5} Pa"
  std::string quantity;
  std::string unit;  // of errors: "relative" and "absolute" are shown in percent
  double bar = 0.0;
  std::vector<Curve> curves;
  std::optional<CurvePoint> chosen;  // what the program takes by itself
  ElasticAccuracy chosen_accuracy;
};

// One panel a modulus, curves in the order they were run. Precondition: the scene measures `quantity`.
std::vector<Panel> panels_of(const ChartScene& scene, const std::string& quantity,
                             const std::vector<ChartRow>& rows);

// "cells, 25 mm"; methods without cells have no width.
std::string curve_label(const ChartRow& row);

}  // namespace livegs::study

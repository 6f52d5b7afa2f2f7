// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "study/chart/chart_curves.h"

namespace livegs::study {

struct Figure {
  std::string title, settings;  // plain text, a line each
  std::vector<Panel> panels;    // the key is that of the first
  bool same_axis = true;        // of errors, for all panels; otherwise each has its own
  std::string note{};           // a line below the settings
};

// Draws it as SVG with gnuplot: error (log) against processor time a simulated second (log), one curve a
// method. Points on the upper edge are beyond the axis or have no finite error; no line leads to the latter.
// Fails when gnuplot is not installed.
Result<void> draw_figure(const Figure& figure, const std::filesystem::path& svg);

Figure elastic_figure(const ChartScene& scene, std::vector<Panel> panels);

}  // namespace livegs::study

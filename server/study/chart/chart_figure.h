// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "study/chart/chart_curves.h"

namespace livegs::study {

struct Figure {
  std::string title, settings;  // plain text, one line each
  std::vector<Panel> panels;    // the key lists the curves of the first panel
  bool same_axis = true;        // one error axis for all panels; otherwise one per panel
  std::string note{};           // a line below the settings
};

// Draws a figure as SVG with gnuplot: error (log) over processor time per simulated second (log), one curve
// per method. Points on the upper edge are beyond the axis or diverged; diverged ones are not connected.
// Fails if gnuplot is not installed.
Result<void> draw_figure(const Figure& figure, const std::filesystem::path& svg);

Figure elastic_figure(const ChartScene& scene, std::vector<Panel> panels);

}  // namespace livegs::study

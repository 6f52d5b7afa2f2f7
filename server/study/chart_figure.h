// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "study/chart_curves.h"

namespace livegs::study {

// Draws a scene's panels as SVG with gnuplot: error (log) against processor time a simulated second (log), one curve a
// method. Points on the upper edge are beyond the axis or did not stay finite. Fails when gnuplot is not installed.
Result<void> draw_figure(const ChartScene& scene, const std::vector<Panel>& panels, const std::filesystem::path& svg);

}  // namespace livegs::study

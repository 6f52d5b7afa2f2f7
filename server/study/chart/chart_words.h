// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "study/chart/chart_curves.h"

namespace livegs::study {

// "1.2 %", "a factor of 20", "0.3 m/s", "no finite result".
std::string error_text(double error, const std::string& unit);

// "youngs_modulus" as "youngs modulus".
std::string spaced(std::string name);

// A table with a row for each method of each panel: first the methods within the panel's bar at their
// cheapest point, cheapest first; then the others at their point of smallest error; then the cells and
// substeps that the program chooses.
std::string compare_curves(const std::vector<Panel>& panels);

}  // namespace livegs::study

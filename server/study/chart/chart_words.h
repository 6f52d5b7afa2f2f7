// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "study/chart/chart_curves.h"

namespace livegs::study {

// "1.2 %", "a factor of 20", "0.3 m/s", "no finite result".
std::string error_text(double error, const std::string& unit);

// One point of a list: which curves meet the panel's bar, cheapest first; which never do, with their best;
// and what the program takes by itself.
std::string compare_curves(const Panel& panel);

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "study/chart/chart_curves.h"

namespace livegs::study {

// "1.2 %", "a factor of 20", "0.3 m/s", "no finite result".
std::string error_text(double error, const std::string& unit);

// One list item: the curves within the panel's bar, cheapest first; the others with their best point; and the
// values chosen by the program.
std::string compare_curves(const Panel& panel);

}  // namespace livegs::study

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

enum class Unit { None, Kilogram, Pascal, Newton, NewtonSecond, Second };

// Formats an SI value with three significant digits and a suitable prefix: "0.35 kg", "85 g", "10 kPa",
// "0.66 N s".
std::string quantity_text(double value, Unit unit);
// "5 to 20 kPa": the unit is written once if both ends share it.
std::string range_text(double low, double high, Unit unit);

// Parses user input to SI: a number in the unit itself, or with one of the prefixes above ("10 kPa", "85g").
// The error lists the accepted forms.
Result<double> parse_quantity(std::string_view text, Unit unit);

// Rounds to three significant digits.
double rounded(double value);

}  // namespace livegs

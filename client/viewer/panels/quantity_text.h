// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

enum class Unit { None, Kilogram, Pascal, Newton, NewtonSecond, Second };

// A value in SI as people read it: three significant digits, with the prefix that keeps it short. "0.35 kg",
// "85 g", "10 kPa", "0.66 N s".
std::string quantity_text(double value, Unit unit);
// "5 to 20 kPa": the unit once where both ends share it.
std::string range_text(double low, double high, Unit unit);

// What a person types, in SI: a number in the unit itself, or with one of the prefixes above ("10 kPa",
// "85g"). The error says what may be typed.
Result<double> parse_quantity(std::string_view text, Unit unit);

// To three significant digits.
double rounded(double value);

}  // namespace livegs

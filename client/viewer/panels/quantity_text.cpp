// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/quantity_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <span>

namespace livegs {
namespace {

struct Prefix {
  double factor;  // value of one unit in SI
  const char* name;
  double from;  // used for values from here on
};

std::span<const Prefix> prefixes_of(Unit unit) {
  static constexpr Prefix kKilogram[] = {{1e-6, "mg", 0}, {1e-3, "g", 1e-3}, {1, "kg", 0.1}};
  static constexpr Prefix kPascal[] = {{1, "Pa", 0}, {1e3, "kPa", 1e3}, {1e6, "MPa", 1e6}, {1e9, "GPa", 1e9}};
  static constexpr Prefix kNewton[] = {{1e-3, "mN", 0}, {1, "N", 0.1}, {1e3, "kN", 1e3}};
  static constexpr Prefix kNewtonSecond[] = {{1e-3, "mN s", 0}, {1, "N s", 0.1}, {1e3, "kN s", 1e3}};
  static constexpr Prefix kSecond[] = {{1e-3, "ms", 0}, {1, "s", 0.1}};
  switch (unit) {
    case Unit::Kilogram:
      return kKilogram;
    case Unit::Pascal:
      return kPascal;
    case Unit::Newton:
      return kNewton;
    case Unit::NewtonSecond:
      return kNewtonSecond;
    case Unit::Second:
      return kSecond;
    case Unit::None:
      return {};
  }
  return {};
}

const Prefix* prefix_for(double value, Unit unit) {
  const Prefix* chosen = nullptr;
  for (const Prefix& prefix : prefixes_of(unit)) {
    if (!chosen || std::abs(value) >= prefix.from) chosen = &prefix;
  }
  // Zero is written in the unit itself.
  if (value == 0) {
    for (const Prefix& prefix : prefixes_of(unit)) {
      if (prefix.factor == 1) chosen = &prefix;
    }
  }
  return chosen;
}

std::string digits(double value) {
  if (value == 0) return "0";
  const int whole = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-12));
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", std::clamp(2 - whole, 0, 9), value);
  std::string plain = text;
  if (plain.find('.') != std::string::npos) {
    plain.erase(plain.find_last_not_of('0') + 1);
    if (plain.back() == '.') plain.pop_back();
  }
  return plain;
}

std::string trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string_view::npos ? "" : std::string(text.substr(begin, end - begin + 1));
}

}  // namespace

double rounded(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  char text[64];
  std::snprintf(text, sizeof text, "%.2e", value);
  double back = value;
  std::from_chars(text, text + sizeof text, back);
  return back;
}

std::string quantity_text(double value, Unit unit) {
  if (!std::isfinite(value)) return "unknown";
  const double shown = rounded(value);
  const Prefix* prefix = prefix_for(shown, unit);
  return prefix ? digits(shown / prefix->factor) + " " + prefix->name : digits(shown);
}

std::string range_text(double low, double high, Unit unit) {
  const Prefix *from = prefix_for(rounded(low), unit), *to = prefix_for(rounded(high), unit);
  const std::string end = quantity_text(high, unit);
  if (low == 0 && to) return "0 to " + end;
  return from == to && from ? digits(rounded(low) / from->factor) + " to " + end
                            : quantity_text(low, unit) + " to " + end;
}

Result<double> parse_quantity(std::string_view text, Unit unit) {
  const std::string plain = trimmed(text);
  std::string names;
  for (const Prefix& prefix : prefixes_of(unit))
    names += (names.empty() ? "" : ", ") + std::string(prefix.name);
  const auto refuse = [&] {
    return invalid_argument(
        "\"" + plain + "\" is not a number" +
        (names.empty() ? std::string() : "; enter a number, alone or followed by " + names));
  };
  double value = 0;
  const auto [end, failed] = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  if (failed != std::errc() || !std::isfinite(value)) return refuse();
  const std::string name = trimmed({end, static_cast<size_t>(plain.data() + plain.size() - end)});
  if (name.empty()) return value;
  for (const Prefix& prefix : prefixes_of(unit)) {
    if (name == prefix.name) return value * prefix.factor;
  }
  return refuse();
}

}  // namespace livegs

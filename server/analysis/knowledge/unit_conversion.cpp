// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/knowledge/unit_conversion.h"

#include <cmath>
#include <string>

// Inches, pounds and derived units are exact (international yard and pound agreement, 1959).

namespace livegs {
namespace {

enum class Quantity { Length, Area, Volume, Mass, Density, Pressure, Force };
struct Unit {
  const char* name;
  Quantity quantity;
  double in_si;
};

constexpr double kInch_m = 0.0254, kFoot_m = 0.3048, kPound_kg = 0.45359237, kGravity_m_s2 = 9.80665;
constexpr Unit kUnits[] = {
    {"m", Quantity::Length, 1},
    {"cm", Quantity::Length, 1e-2},
    {"mm", Quantity::Length, 1e-3},
    {"um", Quantity::Length, 1e-6},
    {"km", Quantity::Length, 1e3},
    {"in", Quantity::Length, kInch_m},
    {"inch", Quantity::Length, kInch_m},
    {"ft", Quantity::Length, kFoot_m},
    {"m2", Quantity::Area, 1},
    {"cm2", Quantity::Area, 1e-4},
    {"mm2", Quantity::Area, 1e-6},
    {"in2", Quantity::Area, kInch_m* kInch_m},
    {"ft2", Quantity::Area, kFoot_m* kFoot_m},
    {"m3", Quantity::Volume, 1},
    {"cm3", Quantity::Volume, 1e-6},
    {"mm3", Quantity::Volume, 1e-9},
    {"in3", Quantity::Volume, kInch_m* kInch_m* kInch_m},
    {"ft3", Quantity::Volume, kFoot_m* kFoot_m* kFoot_m},
    {"l", Quantity::Volume, 1e-3},
    {"ml", Quantity::Volume, 1e-6},
    {"kg", Quantity::Mass, 1},
    {"g", Quantity::Mass, 1e-3},
    {"mg", Quantity::Mass, 1e-6},
    {"t", Quantity::Mass, 1e3},
    {"lb", Quantity::Mass, kPound_kg},
    {"oz", Quantity::Mass, kPound_kg / 16},
    {"kg/m3", Quantity::Density, 1},
    {"g/cm3", Quantity::Density, 1e3},
    {"kg/l", Quantity::Density, 1e3},
    {"lb/ft3", Quantity::Density, kPound_kg / (kFoot_m * kFoot_m * kFoot_m)},
    {"pa", Quantity::Pressure, 1},
    {"kpa", Quantity::Pressure, 1e3},
    {"mpa", Quantity::Pressure, 1e6},
    {"gpa", Quantity::Pressure, 1e9},
    {"bar", Quantity::Pressure, 1e5},
    {"psi", Quantity::Pressure, kPound_kg* kGravity_m_s2 / (kInch_m * kInch_m)},
    {"n", Quantity::Force, 1},
    {"kn", Quantity::Force, 1e3},
    {"kgf", Quantity::Force, kGravity_m_s2},
    {"lbf", Quantity::Force, kPound_kg* kGravity_m_s2},
};

const Unit* find_unit(std::string_view name) {
  std::string plain;
  for (const char c : name.substr(0, 16)) {
    if (c == ' ' || c == '^') continue;
    plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  for (const Unit& unit : kUnits) {
    if (plain == unit.name) return &unit;
  }
  return nullptr;
}

}  // namespace

Result<double> convert_unit(double value, std::string_view from, std::string_view to,
                            const MessageTemplates& words) {
  const Unit* source = find_unit(from);
  const Unit* target = find_unit(to);
  if (!source) return invalid_argument(words.say("from_unknown"));
  if (!target) return invalid_argument(words.say("to_unknown"));
  if (source->quantity != target->quantity) return invalid_argument(words.say("other_quantity"));
  const double converted = value * source->in_si / target->in_si;
  if (!std::isfinite(converted)) return invalid_argument(words.say("value_too_large"));
  return converted;
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/parameter_slider.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

struct FieldRow {
  const char* name;
  Unit unit;
  double low, high;  // range of the slider; the server accepts more, typed
  bool logarithmic;
};

const FieldRow& row_of(SliderParameter field) {
  static constexpr FieldRow kRows[] = {
      {"Mass", Unit::Kilogram, 1e-3, 1e3, true},
      {"Young's modulus", Unit::Pascal, 1e2, 1e11, true},
      {"Deformation resistance", Unit::None, 1e-3, 1, false},
      {"Plasticity", Unit::None, 0, 1, false},
      {"Break impulse", Unit::NewtonSecond, 1e-2, 1e3, true},
      {"Friction", Unit::None, 0, 2, false},
  };
  return kRows[static_cast<size_t>(field)];
}

}  // namespace

std::vector<SliderParameter> slider_parameters(const v1::PhysicalParameters& physics) {
  switch (physics.behavior()) {
    case v1::Physics::ELASTIC:
      return {SliderParameter::Mass, SliderParameter::YoungsModulus, SliderParameter::DeformationResistance,
              SliderParameter::Plasticity, SliderParameter::Friction};
    case v1::Physics::STATIC:
      return {SliderParameter::Friction};
    default:
      if (physics.fragile())
        return {SliderParameter::Mass, SliderParameter::BreakImpulse, SliderParameter::Friction};
      return {SliderParameter::Mass, SliderParameter::Friction};
  }
}

const char* parameter_name(SliderParameter field) { return row_of(field).name; }
Unit parameter_unit(SliderParameter field) { return row_of(field).unit; }

SliderRange slider_range(SliderParameter field, const v1::EstimatedValue& value) {
  constexpr double kMargin = 10;  // on both sides of the plausible range
  const FieldRow& row = row_of(field);
  SliderRange range{row.low, row.high, row.logarithmic};
  if (!row.logarithmic || !(value.best() > 0)) return range;
  const double low = value.low() > 0 ? std::min(value.low(), value.best()) : value.best();
  range.low = std::clamp(low / kMargin, row.low, row.high / kMargin);
  range.high = std::clamp(std::max(value.high(), value.best()) * kMargin, kMargin * range.low, row.high);
  return range;
}

double slider_position(const SliderRange& range, double value) {
  const double inside = std::clamp(value, range.low, range.high);
  if (!range.logarithmic) return (inside - range.low) / (range.high - range.low);
  return std::log(inside / range.low) / std::log(range.high / range.low);
}

double slider_value(const SliderRange& range, double position) {
  const double share = std::clamp(position, 0.0, 1.0);
  const double value = range.logarithmic ? range.low * std::pow(range.high / range.low, share)
                                         : range.low + share * (range.high - range.low);
  return rounded(value);
}

v1::EstimatedValue shown_value(SliderParameter field, const v1::PhysicalParameters& physics) {
  switch (field) {
    case SliderParameter::Mass:
      return physics.mass_kg();
    case SliderParameter::YoungsModulus: {
      v1::EstimatedValue value = physics.youngs_modulus_pa();
      const v1::EstimatedValue& share = physics.structure_coefficient();
      if (share.best() <= 0 || share.best() == 1) return value;
      value.set_low(share.low() * value.low());
      value.set_best(share.best() * value.best());
      value.set_high(share.high() * value.high());
      value.set_reason(quantity_text(physics.youngs_modulus_pa().best(), Unit::Pascal) + " of " +
                       physics.material() + " times " + quantity_text(share.best(), Unit::None) +
                       " for the structure. " + value.reason());
      return value;
    }
    case SliderParameter::DeformationResistance:
      return physics.deformation_resistance();
    case SliderParameter::Plasticity:
      return physics.plasticity();
    case SliderParameter::BreakImpulse:
      return physics.break_impulse_n_s();
    case SliderParameter::Friction:
      return physics.friction();
  }
  return {};
}

v1::Physics edit_of(SliderParameter field, double value) {
  v1::Physics edit;
  switch (field) {
    case SliderParameter::Mass:
      edit.set_mass_kg(value);
      break;
    case SliderParameter::YoungsModulus:
      edit.set_youngs_modulus_pa(value);
      break;
    case SliderParameter::DeformationResistance:
      edit.set_deformation_resistance(value);
      break;
    case SliderParameter::Plasticity:
      edit.set_plasticity(value);
      break;
    case SliderParameter::BreakImpulse:
      edit.set_break_impulse_n_s(value);
      break;
    case SliderParameter::Friction:
      edit.set_friction(value);
      break;
  }
  return edit;
}

std::vector<std::string> fields_of(SliderParameter field) {
  switch (field) {
    case SliderParameter::Mass:
      return {"mass_kg", "density_kg_m3"};
    case SliderParameter::YoungsModulus:
    case SliderParameter::DeformationResistance:  // one is computed from the other
      return {"youngs_modulus_pa", "deformation_resistance"};
    case SliderParameter::Plasticity:
      return {"plasticity"};
    case SliderParameter::BreakImpulse:
      return {"break_impulse_n_s"};
    case SliderParameter::Friction:
      return {"friction"};
  }
  return {};
}

v1::Physics edit_of_fragile(bool fragile) {
  v1::Physics edit;
  edit.set_fragile(fragile);
  return edit;
}

const char* source_text(v1::EstimatedValue::Source source) {
  switch (source) {
    case v1::EstimatedValue::OFFLINE:
      return "estimate";
    case v1::EstimatedValue::MODEL:
      return "language model";
    case v1::EstimatedValue::SCENE:
      return "scene file";
    case v1::EstimatedValue::PERSON:
      return "set by hand";
    case v1::EstimatedValue::DEFAULT:
      return "default";
    default:
      return "unknown";
  }
}

}  // namespace livegs

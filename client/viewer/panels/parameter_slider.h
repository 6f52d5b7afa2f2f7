// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "livegs/v1/physics.pb.h"
#include "viewer/panels/quantity_text.h"

namespace livegs {

// Object parameters that can be edited in the window. Pure functions; any thread.
enum class SliderParameter { Mass, YoungsModulus, DeformationResistance, Plasticity, BreakImpulse, Friction };

// Parameters that apply to an object: stiffness and plasticity if elastic, fracture otherwise.
std::vector<SliderParameter> slider_parameters(const v1::PhysicalParameters& physics);

const char* parameter_name(SliderParameter field);  // "Young's modulus"
Unit parameter_unit(SliderParameter field);

// Values at the ends of a slider. Logarithmic for mass, modulus and impulse: ten times the plausible range to
// both sides, and the value itself, within the range of the field. Otherwise the whole range of the field.
struct SliderRange {
  double low = 0, high = 1;
  bool logarithmic = false;
};
SliderRange slider_range(SliderParameter field, const v1::EstimatedValue& value);
// Converts between a value and its slider position, 0 to 1. Positions are clamped; values are rounded to
// three digits, as displayed.
double slider_position(const SliderRange& range, double value);
double slider_value(const SliderRange& range, double position);

// The displayed value. The modulus is that of the whole body, E* = s E, since an edit sets it; its range is
// that of the product.
v1::EstimatedValue shown_value(SliderParameter field, const v1::PhysicalParameters& physics);

// The SetPhysics request that sets the field to this value.
v1::Physics edit_of(SliderParameter field, double value);
// The fields of Physics that set this parameter.
std::vector<std::string> fields_of(SliderParameter field);
// Leaves the impulse unchanged: the server computes one for a newly fragile object.
v1::Physics edit_of_fragile(bool fragile);

// "a person", "the scene file", …
const char* source_text(v1::EstimatedValue::Source source);

}  // namespace livegs

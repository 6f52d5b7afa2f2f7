// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "livegs/v1/physics.pb.h"
#include "viewer/panels/quantity_text.h"

namespace livegs {

// The values of an object that a person changes in the window. Pure functions; any thread.
enum class SliderParameter { Mass, YoungsModulus, DeformationResistance, Plasticity, BreakImpulse, Friction };

// Those that mean something for an object: stiffness and plasticity of what is elastic, breaking of what is
// not.
std::vector<SliderParameter> slider_parameters(const v1::PhysicalParameters& physics);

const char* parameter_name(SliderParameter field);  // "Young's modulus"
Unit parameter_unit(SliderParameter field);

// The field's place on its slider, 0 to 1, and back: logarithmic for mass, modulus and impulse, linear for
// the others. Places outside are at its ends; values are rounded to three digits, as they are shown.
double slider_position(SliderParameter field, double value);
double slider_value(SliderParameter field, double position);

// The modulus is that of the whole body, E* = s E, since that is what an edit of it sets; its range is that
// of the product.
v1::EstimatedValue shown_value(SliderParameter field, const v1::PhysicalParameters& physics);

// What SetPhysics is asked for when the field shall have this value.
v1::Physics edit_of(SliderParameter field, double value);
// Nothing of an impulse is changed: the server works one out for what has just become fragile.
v1::Physics edit_of_fragile(bool fragile);

// "a person", "the scene file", …
const char* source_text(v1::EstimatedValue::Source source);

}  // namespace livegs

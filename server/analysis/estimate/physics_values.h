// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "analysis/knowledge/tables.h"
#include "livegs/v1/physics.pb.h"

namespace livegs {

// A value of PhysicalParameters and the field of Physics that sets it.
struct PhysicsValue {
  const char* name;  // of both
  const v1::EstimatedValue& (v1::PhysicalParameters::*get)() const;
  v1::EstimatedValue* (v1::PhysicalParameters::*mutable_value)();
  bool (v1::PhysicalParameters::*has)() const;
  void (v1::Physics::*set)(double);
};
std::span<const PhysicsValue> physics_values();

// True if the value is from a user or the scene; such a value is not replaced.
bool is_locked(const v1::EstimatedValue& value);

inline Span3 span_of(const v1::EstimatedValue& value) { return {value.low(), value.best(), value.high()}; }

// `mass_share`: fraction of the object's mass, 0 to 1.
void add_material_part(v1::PhysicalParameters& parameters, const std::string& name,
                       const std::string& material, double mass_share);

// Name of a value's source for users: "offline" (the offline estimator), "model", "scene", "person",
// "default", "unknown".
const char* source_name(v1::EstimatedValue::Source source);

// The word of the answer schema: "solid", "shell", "open_shell", "filled", else "unknown".
const char* fill_name(v1::Physics::Fill fill);

}  // namespace livegs

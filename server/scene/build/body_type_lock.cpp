// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/body_type_lock.h"

#include "analysis/division/part_places.h"
#include "scene/build/fracture_warning.h"

namespace livegs {
namespace {

// Without the densities, which follow from the body.
std::string bytes_of_parts(MaterialParts parts) {
  v1::PhysicalParameters only;
  for (v1::MaterialPart& part : parts) part.clear_density_kg_m3();
  *only.mutable_parts() = std::move(parts);
  return only.SerializeAsString();
}

}  // namespace

std::vector<std::string> lock_body_type(const BodyTypeLock& built, v1::PhysicalParameters& physics) {
  std::vector<std::string> later;
  const auto never = fracture_warning(physics);
  if (physics.behavior() != built.behavior) {
    later.push_back("behavior: stays " + v1::Physics::Behavior_Name(built.behavior) +
                    " until the scene is reloaded, then changes to " +
                    v1::Physics::Behavior_Name(physics.behavior()));
    physics.set_behavior(built.behavior);
    physics.set_behavior_reason(later.back());
  }
  if (physics.fragile() && !built.can_break) {
    later.push_back(never.value_or("fragile: no effect until the scene is reloaded"));
  }
  const bool divided = PartPlaces(built.parts).divided() || PartPlaces(physics.parts()).divided();
  if (divided && bytes_of_parts(built.parts) != bytes_of_parts(physics.parts())) {
    later.push_back("parts: change when the scene is reloaded");
    physics.set_parts_reason(later.back());
  } else if (divided) {
    *physics.mutable_parts() = built.parts;  // with their densities
  }
  return later;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/fracture_warning.h"

namespace livegs {

std::optional<std::string> fracture_warning(const v1::PhysicalParameters& physics) {
  if (!physics.fragile() || physics.behavior() == v1::Physics::RIGID) return std::nullopt;
  return "fragile: no effect, only RIGID objects break, and this object is " +
         v1::Physics::Behavior_Name(physics.behavior()) + "; set behavior to RIGID";
}

}  // namespace livegs

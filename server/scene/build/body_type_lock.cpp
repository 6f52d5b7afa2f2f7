// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/body_type_lock.h"

#include "scene/build/fracture_warning.h"

namespace livegs {

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
  return later;
}

}  // namespace livegs

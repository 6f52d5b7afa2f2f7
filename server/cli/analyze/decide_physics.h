// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "livegs/v1/scene.pb.h"

namespace livegs {

// A user's decision about an analysed object. Exactly one field is set, to the object's name in the scene.
struct PhysicsDecision {
  std::string accept, decline, undo, redo;

  bool any() const { return !accept.empty() || !decline.empty() || !undo.empty() || !redo.empty(); }
};

// Changes the object's sidecar and prints its new contents. Does not open assets. `folder` and `scene_name`
// as in sidecar_paths.h. Returns the exit code.
int decide_physics(const PhysicsDecision& decision, const v1::Scene& scene,
                   const std::filesystem::path& folder, const std::string& scene_name);

}  // namespace livegs

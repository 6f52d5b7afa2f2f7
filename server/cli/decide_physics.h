// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "livegs/v1/scene.pb.h"

namespace livegs {

// What a person decides about an object that was analysed, by its name in the scene; one of the four is
// given.
struct PhysicsDecision {
  std::string accept, decline, undo, redo;

  bool any() const { return !accept.empty() || !decline.empty() || !undo.empty() || !redo.empty(); }
};

// Changes the object's sidecar and prints what it holds now. Assets are not opened. `folder` and `scene_name`
// as in sidecar_paths.h. The exit code.
int decide_physics(const PhysicsDecision& decision, const v1::Scene& scene,
                   const std::filesystem::path& folder, const std::string& scene_name);

}  // namespace livegs

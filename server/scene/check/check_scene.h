// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// Most substeps per tick that a scene or an object may ask for.
inline constexpr int kMaxSubsteps = 1024;

// Checks a scene file without opening its assets: list lengths, ranges, dangling references and duplicate
// names. The error names the field. Called by Scene::build and by read_scene_file()
// (run/read_scene_file.cpp); the latter reports JSON and schema errors itself and puts the file name before
// every error. The checks of values are in check_scene.cpp, check_object.cpp and values/scene_values.cpp.
Result<void> check_scene(const v1::Scene& scene);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// Maximum number of substeps per tick of a scene or an object. Larger: ticks may take longer.
inline constexpr int kMaxSubsteps = 1024;

// Checks a scene file without opening its assets: list lengths, ranges, dangling references and duplicate
// names. The error begins with the field, and the reader of a file adds the file name. JSON and schema
// errors are reported by read_scene_file() (run/read_scene_file.cpp). The checks of values are in
// check_scene.cpp, check_object.cpp and values/scene_values.cpp.
Result<void> check_scene(const v1::Scene& scene);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// Checks a scene file without opening its assets: list lengths, ranges, dangling references and duplicate
// names. The error names the field.
Result<void> check_scene(const v1::Scene& scene);

}  // namespace livegs

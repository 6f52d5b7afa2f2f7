// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// What can be said about a scene without opening its assets: lengths of lists, ranges, names that refer to
// nothing or stand twice. The error names the field.
Result<void> check_scene(const v1::Scene& scene);

}  // namespace livegs

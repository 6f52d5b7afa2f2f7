// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// A scene with a floor and one asset on it: a splat file, or the index of an unpacked one. Paths in it are
// relative to the folder of `path`.
Result<v1::Scene> scene_of_asset(const std::filesystem::path& path, bool drop);

}  // namespace livegs

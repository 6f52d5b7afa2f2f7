// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "livegs/v1/scene.pb.h"

namespace livegs {

// The scene with its paths, which are relative to `from`, made relative to the folder `to`.
v1::Scene rebase_scene(v1::Scene scene, const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "core/result.h"
#include "scene/scene.h"
#include "splat/camera.h"

namespace livegs {

// The JSON form of livegs.v1.CameraFile.
Result<Camera> read_camera_file(const std::filesystem::path& path);

}  // namespace livegs

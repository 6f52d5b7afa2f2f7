// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "core/result.h"
#include "splat/camera.h"

namespace livegs {

// The JSON form of livegs.v1.CameraFile. Its width and height, where it has them, give way to `size`, if
// there is one.
struct PictureSize {
  int width = 640, height = 480;
};
Result<Camera> read_camera_file(const std::filesystem::path& path, std::optional<PictureSize> size);

// What read_camera_file and `livegs render --camera` take, of a camera without an asymmetric frustum.
Result<void> write_camera_file(const std::filesystem::path& path, const Camera& camera);

}  // namespace livegs

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

// A camera and the size of its pictures, where a file says them; without a file `size`, or its default.
struct PictureChoice {
  std::optional<Camera> camera;
  PictureSize size;
};
Result<PictureChoice> picture_choice(const std::filesystem::path& camera_file, std::optional<PictureSize> size);

// What read_camera_file and `livegs render --camera` take, of a camera without an asymmetric frustum.
Result<void> write_camera_file(const std::filesystem::path& path, const Camera& camera);

}  // namespace livegs

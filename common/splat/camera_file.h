// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "core/result.h"
#include "splat/camera.h"

// Camera files: the JSON form of livegs.v1.CameraFile (proto/livegs/v1/scene.proto).

namespace livegs {

struct PictureSize {
  int width = 640, height = 480;
};
// `size` overrides the width and height of the file.
Result<Camera> read_camera_file(const std::filesystem::path& path, std::optional<PictureSize> size = {});

// The camera of a file and the size of its images. Without a file: no camera, and `size` or its default.
struct PictureChoice {
  std::optional<Camera> camera;
  PictureSize size;
};
Result<PictureChoice> picture_choice(const std::filesystem::path& camera_file,
                                     std::optional<PictureSize> size);

// Writes a file for read_camera_file. Asymmetric frusta are not preserved.
Result<void> write_camera_file(const std::filesystem::path& path, const Camera& camera);

}  // namespace livegs

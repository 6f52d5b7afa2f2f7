// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "splat/camera.h"

namespace livegs {

// The cameras of a transforms.json file (instant-ngp, nerfstudio): intrinsics global or per frame, poses as
// OpenGL camera-to-world matrices in the frame of the splat. Lens distortion is ignored.
struct NamedCamera {
  std::string name;  // of the photo, without folders and ending
  Camera camera;
};
Result<std::vector<NamedCamera>> read_transforms(const std::filesystem::path& path);

// The mean up axis of the cameras, unit: photos are mostly taken level.
Eigen::Vector3d mean_up(const std::vector<Camera>& cameras);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/result.h"
#include "render/choose_camera.h"
#include "render/scene_view.h"
#include "splat/camera_file.h"
#include "viewer/camera/orbit_camera.h"

namespace livegs {

// The initial camera: from the file, or chosen so that the posed scene is visible in the columns `free`.
Result<Camera> initial_camera(const SceneView& view, PictureSize size,
                              const std::filesystem::path& camera_file,
                              const std::optional<PictureColumns>& free = {});
// An orbit camera at that position around the centre of the scene.
OrbitCamera orbit_of(const SceneView& view, const Camera& camera);

}  // namespace livegs

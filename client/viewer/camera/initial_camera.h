// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/result.h"
#include "render/choose_camera.h"
#include "render/scene_view.h"
#include "splat/camera_file.h"
#include "viewer/camera/orbit_camera.h"

namespace livegs {

// Where one looks from at first: as the file says, or so that all of the posed scene is seen, in columns that
// nothing covers.
Result<Camera> initial_camera(const SceneView& view, PictureSize size,
                              const std::filesystem::path& camera_file,
                              const std::optional<PictureColumns>& free = {});
// That camera about the middle of the scene.
OrbitCamera orbit_of(const SceneView& view, const Camera& camera);

}  // namespace livegs

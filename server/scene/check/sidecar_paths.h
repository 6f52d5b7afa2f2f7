// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "livegs/v1/scene.pb.h"

namespace livegs {

// Returns the path of each object's sidecar (NAME.physics.json), in the scene's order, whether the file
// exists or not. Reads the file system.
// - An asset that only one object uses: the asset's sidecar.
// - An asset that several objects share: one sidecar per object, named after the object.
// - An existing sidecar named after the object always takes precedence.
// - A shape: next to the scene file `scene_name` in `folder`; empty if that is not a *.scene.json.
std::vector<std::filesystem::path> sidecar_paths(const v1::Scene& scene, const std::filesystem::path& folder,
                                                 const std::string& scene_name);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "livegs/v1/scene.pb.h"

namespace livegs {

// Where what is decided about each object of a scene is kept, in the scene's order, whether it is there or
// not. What shows an asset alone has the asset's sidecar, what shares it has its own, named after the object;
// one of its own that is there already stays in use. A shape's stands beside the scene file, `scene_name` in
// `folder`; empty where that is no
// *.scene.json. Looks at the disk.
std::vector<std::filesystem::path> sidecar_paths(const v1::Scene& scene, const std::filesystem::path& folder,
                                                 const std::string& scene_name);

}  // namespace livegs

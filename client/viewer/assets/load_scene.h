// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene_view.h"
#include "stream/received/received.h"
#include "viewer/assets/asset_library.h"

namespace livegs {

// Loads the objects of the scene into the view; blocks until all are complete.
Result<void> load_scene(const JoinedScene& scene, AssetLibrary& assets, SceneView& view);

}  // namespace livegs

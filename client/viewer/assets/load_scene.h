// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene_view.h"
#include "stream/received/received.h"
#include "viewer/assets/asset_library.h"

namespace livegs {

// Fetches what the scene shows and adds it to the view; waits until all is there.
Result<void> load_scene(const JoinedScene& scene, AssetLibrary& assets, SceneView& view);

}  // namespace livegs

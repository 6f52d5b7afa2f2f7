// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

#include "viewer/live/scene_loader.h"
#include "xr/window_display.h"

namespace livegs {

// Shows in the window how far a loading is, until it is done. Null when the window was closed or it was
// `interrupted`: the loading is to be given up.
Result<std::unique_ptr<ConnectedScene>> load_in_window(SceneLoader& loading, WindowDisplay& display,
                                                       const std::atomic<bool>& interrupted);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

#include "viewer/live/scene_loader.h"
#include "xr/window_display.h"

namespace livegs {

// Shows loading progress in the window until it is done. Null if the window was closed or on `interrupted`:
// the caller must cancel the loading.
Result<std::unique_ptr<ConnectedScene>> load_in_window(SceneLoader& loading, WindowDisplay& display,
                                                       const std::atomic<bool>& interrupted);

}  // namespace livegs

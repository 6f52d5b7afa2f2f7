// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "splat/camera_file.h"
#include "viewer/live/connected_scene.h"
#include "xr/window/window_panels.h"

namespace livegs {

struct WindowRunOptions : JoinOptions {
  double seconds = 0;  // 0: until the window is closed
  std::optional<PictureSize> size;
  double ui_scale = 0;                // of texts and panels; 0: that of the monitor
  bool full_size = false;             // always render at full resolution
  std::filesystem::path camera_file;  // empty: all objects from slightly above
  std::string poke;                   // object to poke as if by the mouse; empty: none
  std::string select;                 // object selected in the panels at the start; empty: none
  // Forces applied together and recorded at the start; without `seconds` the window closes afterwards.
  std::vector<v1::Event::Force> forces;
  // Folder for recordings and for window_NNN.png, one per second; empty: none.
  std::filesystem::path screenshots;
  int screenshot_every = 0;  // saves every Nth picture instead; 0: one per second
  // Called with each displayed picture, panels included, and the contents of the Run panel.
  std::function<void(const Image& shown, const RunPanel& run)> on_picture;
};

// Joins and shows the scene in a window, with mouse control of the view, pulling and shooting. When the
// server is lost, the last picture stays with a notice while the client reconnects. Runs until the window is
// closed, the time is up, or `interrupted`. A recording in progress is then cut to the drawn part, or removed
// if no picture was drawn. An incomplete recording of `forces` is an error, Unavailable, with the number of
// pictures.
Result<void> run_window(const WindowRunOptions& options, const std::atomic<bool>& interrupted);

}  // namespace livegs

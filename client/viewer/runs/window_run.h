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
  bool full_size = false;             // pictures are drawn at the window's size even where they come late
  std::filesystem::path camera_file;  // empty: all objects from a little above
  std::string poke;                   // an object that is poked as if by the mouse; empty: none
  std::string select;                 // an object that the panels are about from the start; empty: none
  // Forces that are applied together and recorded at the start; without `seconds` the window is closed after
  // it.
  std::vector<v1::Event::Force> forces;
  std::filesystem::path
      screenshots;           // a folder for window_NNN.png, one a second, and recordings; empty: none
  int screenshot_every = 0;  // so many pictures, in place of one a second; 0: one a second
  // Called with each picture of the scene as it was shown, panels included, and with what Run says in it.
  std::function<void(const Image& shown, const RunPanel& run)> on_picture;
};

// Joins and shows the scene in a window, in which the mouse turns the view, takes hold of things and shoots.
// When the server goes, its last picture stays with a notice, and it is looked for. Until the window is
// closed, the time is up or `interrupted`: a recording under way then is a video of what was drawn of it, or,
// before its first picture, nothing is left of it. One of `forces` that is not whole is an error,
// Unavailable, which says how much there is.
Result<void> run_window(const WindowRunOptions& options, const std::atomic<bool>& interrupted);

}  // namespace livegs

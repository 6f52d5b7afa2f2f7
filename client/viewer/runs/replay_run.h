// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/result.h"
#include "render/choose_renderer.h"
#include "splat/camera_file.h"
#include "splat/image.h"
#include "viewer/assets/asset_library.h"
#include "viewer/output/frame_log.h"

namespace livegs {

// Options for playing a recording (proto/recording_format.md); no server is needed.
struct ReplayOptions {
  std::filesystem::path file;
  double from_s = 0;            // start, after the first frame
  double seconds = 0;           // duration; 0: to the end
  std::filesystem::path cache;  // of assets; empty: the user's cache
  std::filesystem::path output = "out/replay";
  std::optional<PictureSize> size;
  std::filesystem::path camera_file;  // empty: all objects from slightly above
  double video_rate_hz = 30;
  int png_every = 30;
  bool video = true;
  RendererChoice renderer = RendererChoice::Auto;
  bool shadows = true;  // as in SceneView::set_shadows
  // Window only.
  double ui_scale = 0;     // of texts and panels; 0: that of the monitor
  bool full_size = false;  // always render at full resolution
  struct Moment {
    double shown_s = 0;  // after the first frame
    bool paused = false, at_end = false;
  };
  // Called with each picture, panels included.
  std::function<void(const Image& shown, const Moment& moment)> on_picture;
};

struct ReplaySummary {
  std::string file, renderer, scene;
  std::string notice;  // as in OffscreenRunSummary
  double length_s = 0, from_s = 0;
  size_t frames_decoded_to_seek = 0;
  AssetLibrary::Totals assets;
  DrawnLog::Summary drawn;
  std::optional<Error> error;  // read error of the recording
};

// Assets of a recording: from the cache, else embedded ones.
AssetLibrary::FetchAsset assets_of_recording(const std::filesystem::path& file);

// InvalidArgument, with the length, if the start is beyond the end.
Result<void> check_from(const ReplayOptions& options, double length_s);

// Draws the recording into `output`: out.mp4, frame_NNNNN.png, first.png, last.png, last_frame.bin,
// camera.json and timings.csv as run_offscreen() does. Every display time is drawn, however long it takes.
Result<ReplaySummary> run_replay(const ReplayOptions& options, const std::atomic<bool>& interrupted);
std::string summary_text(const ReplaySummary& summary);

// Plays the recording in a window: the mouse rotates the view, P pauses, the full stop steps, the arrow keys
// jump by five seconds, Home restarts. Runs until the window is closed or `interrupted`. Pauses at the end,
// or, with `seconds`, closes the window.
Result<void> run_replay_window(const ReplayOptions& options, const std::atomic<bool>& interrupted);

}  // namespace livegs

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

// Of a recording (proto/recording_format.md) that is watched; no server is needed.
struct ReplayOptions {
  std::filesystem::path file;
  double from_s = 0;            // after its first frame
  double seconds = 0;           // of it; 0: to its end
  std::filesystem::path cache;  // of assets; empty: the user's
  std::filesystem::path output = "out/replay";
  std::optional<PictureSize> size;
  std::filesystem::path camera_file;  // empty: all objects from a little above
  double video_rate_hz = 30;
  int png_every = 30;
  bool video = true;
  RendererChoice renderer = RendererChoice::Auto;
  // Of the window.
  bool full_size = false;  // pictures are drawn at its size even where they come late
  struct Moment {
    double shown_s = 0;  // after the first frame
    bool paused = false, at_end = false;
  };
  std::function<void(const Image& shown, const Moment& moment)>
      on_picture;  // called with each, panels included
};

struct ReplaySummary {
  std::string file, renderer, scene;
  std::string notice;  // as OffscreenRunSummary has it
  double length_s = 0, from_s = 0;
  size_t frames_decoded_to_seek = 0;
  AssetLibrary::Totals assets;
  DrawnLog::Summary drawn;
  std::optional<Error> error;  // where the recording could not be read further
};

// The assets of a recording: those of the cache, else those that it holds itself.
AssetLibrary::FetchAsset assets_of_recording(const std::filesystem::path& file);

// InvalidArgument, with the length, where it has no such moment.
Result<void> check_from(const ReplayOptions& options, double length_s);

// Draws it into `output`: out.mp4, frame_NNNNN.png, first.png, last.png, last_frame.bin, camera.json and
// timings.csv as run_offscreen() does, every moment of it, however long drawing takes.
Result<ReplaySummary> run_replay(const ReplayOptions& options, const std::atomic<bool>& interrupted);
std::string summary_text(const ReplaySummary& summary);

// Shows it in a window: the mouse turns the view, P halts, the full stop steps, the arrow keys go five
// seconds back and on, Home goes to its beginning. Until the window is closed or `interrupted`; at its end it
// halts, or with `seconds` the window is closed.
Result<void> run_replay_window(const ReplayOptions& options, const std::atomic<bool>& interrupted);

}  // namespace livegs

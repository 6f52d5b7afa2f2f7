// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "splat/camera_file.h"
#include "viewer/assets/asset_library.h"
#include "viewer/live/connected_scene.h"
#include "viewer/output/frame_log.h"
#include "viewer/output/offscreen_sink.h"

namespace livegs {

struct OffscreenRunOptions : JoinOptions {
  OffscreenRunOptions() {  // a run that ends by itself does not look for ever
    reconnect_s = 10;
    reconnect_after_drain = false;
  }
  double seconds = 10;  // of stream, after the first frame; 0: until the server ends or `interrupted`
  std::filesystem::path output = "out/client";
  std::optional<PictureSize> size;
  std::filesystem::path camera_file, script_file;  // empty: none
  std::string poke;                                // an object's name; empty: none
  double video_rate_hz = 30;
  int png_every = 30;
  bool video = true;
};

struct OffscreenRunSummary {
  std::string scene_address;
  std::string renderer;       // "cpu", or the Vulkan device
  std::string notice;         // what was out of order with the last picture; empty: nothing
  double server_rate_hz = 0;  // frames a second that it is to send
  size_t objects = 0, kernels = 0;
  std::vector<std::string> object_summaries;  // one an object: what it is, and how far its numbers hold
  AssetLibrary::Totals assets;
  ReceivedLog::Summary received;
  DrawnLog::Summary drawn;
  OffscreenSink::Outages outages;
  uint64_t dropped_frames = 0;        // received, but never drawn: the backlog was full
  std::optional<Error> stream_error;  // how the stream broke, if it did; the outputs are complete up to there
};

// Frames that wait to be drawn may hold this much: four minutes at 90 Hz and 25 kB.
inline constexpr size_t kMaxBacklogBytes = 512u << 20;

// Joins, fetches, records the stream for its time and draws it, into `output`:
//   out.mp4, frame_NNNNN.png    the video, and some of its pictures
//   first.png, last.png         the first picture, and one of the very last frame
//   last_frame.bin, camera.json that frame's bytes (not of kernels) and the camera: `livegs render SCENE
//   --frame --camera` draws it again frames.csv, timings.csv     a row a received frame; a row a drawn
//   picture
// The stream is taken at its full rate while drawing follows as fast as it can, from a bounded backlog of
// encoded frames; after the time is up the session ends and the rest is drawn. Fails when it could not start,
// or was interrupted before; a stream that breaks later is in the summary.
Result<OffscreenRunSummary> run_offscreen(const OffscreenRunOptions& options,
                                          const std::atomic<bool>& interrupted);

std::string summary_text(const OffscreenRunSummary& summary);

}  // namespace livegs

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
  OffscreenRunOptions() {  // a run with a fixed length does not reconnect without limit
    reconnect_s = 10;
    reconnect_after_drain = false;
  }
  double seconds = 10;  // of the stream, after the first frame; 0: until the server ends or `interrupted`
  std::filesystem::path output = "out/client";
  std::optional<PictureSize> size;
  std::filesystem::path camera_file, script_file;  // empty: none
  std::string poke;                                // name of an object; empty: none
  double video_rate_hz = 30;
  int png_every = 30;
  bool video = true;
};

struct OffscreenRunSummary {
  std::string scene_address;
  std::string renderer;       // "cpu", or the Vulkan device
  std::string notice;         // a problem with the last picture; empty: none
  double server_rate_hz = 0;  // nominal frames per second
  size_t objects = 0, kernels = 0;
  std::vector<std::string> object_summaries;  // one per object: type and accuracy
  AssetLibrary::Totals assets;
  ReceivedLog::Summary received;
  DrawnLog::Summary drawn;
  OffscreenSink::Outages outages;
  uint64_t dropped_frames = 0;        // received but not drawn, because the backlog was full
  std::optional<Error> stream_error;  // reason of a broken stream; the outputs are complete up to there
  bool error_logged = false;          // the reason was logged when the stream ended
};

// Memory limit of frames that wait to be drawn: four minutes at 90 Hz and 25 kB.
inline constexpr size_t kMaxBacklogBytes = 512u << 20;

// Joins a server, fetches assets, records the stream for the given time and draws it into `output`:
//   out.mp4, frame_NNNNN.png      the video, and some of its pictures
//   first.png, last.png           the first picture, as soon as it is drawn; and one of the very last frame
//   last_frame.bin, camera.json   that frame's bytes (not for kernels) and the camera, for
//                                 `livegs render SCENE --frame --camera`
//   frames.csv, timings.csv       one row per received frame; one row per drawn picture
//
// The stream is received at its full rate; drawing follows from a bounded backlog of encoded frames. Pictures
// that no file contains are not drawn. The reason of an early end is logged at once. After the time is up the
// session ends and the rest is drawn. Fails if it cannot start or was interrupted before;
// a later break of the stream is reported in the summary.
Result<OffscreenRunSummary> run_offscreen(const OffscreenRunOptions& options,
                                          const std::atomic<bool>& interrupted);

std::string summary_text(const OffscreenRunSummary& summary);

}  // namespace livegs

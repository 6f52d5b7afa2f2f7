// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "render/scene_view.h"
#include "viewer/live/connected_scene.h"
#include "xr/headset_display.h"

namespace livegs {

struct HeadsetRunOptions : JoinOptions {  // `renderer` Cpu: drawn on the CPU and uploaded
  double seconds = 0;                     // after the first frame; 0: until the runtime ends the session
  std::filesystem::path camera_file;      // initial view; empty: all objects from slightly above
  bool scales = true;                     // reduces the resolution when pictures are late
  bool marks = true;                      // shows hands, rays and forces
  // Called with each submitted picture and the scene it shows.
  std::function<void(const PlannedFrame& picture, const SceneView& view)> on_picture;
  // Replaces the measured time of rasterising a picture, from which the resolution follows; empty: measured.
  std::function<double(const PlannedFrame& picture)> raster_ms;
};

struct HeadsetRunSummary {
  std::string runtime, renderer;
  HeadsetDisplay::Counts counts;
  // Latency from a hand sample to the first displayed picture of a tick that contains it, and the drawing
  // time in it. Medians and 95th percentiles.
  double hand_to_picture_ms_p50 = 0, hand_to_picture_ms_p95 = 0, draw_ms_p50 = 0, draw_ms_p95 = 0;
  size_t vibrations = 0;
};

// Joins and shows the scene in a headset. Hands pull, grab and shoot, with haptic feedback. Reconnects when
// the server or the headset is lost; the scene keeps its last state. Runs until the runtime ends the session,
// the time is up, or `interrupted`.
Result<HeadsetRunSummary> run_headset(const HeadsetRunOptions& options, HeadsetDisplay& display,
                                      const std::atomic<bool>& interrupted);

std::string summary_text(const HeadsetRunSummary& summary);

}  // namespace livegs

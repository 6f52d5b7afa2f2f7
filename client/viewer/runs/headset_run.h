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

struct HeadsetRunOptions : JoinOptions {  // `renderer` Cpu: drawn there and uploaded
  double seconds = 0;                     // after the first frame; 0: until the runtime ends the session
  std::filesystem::path camera_file;  // where one stands at the start; empty: all objects from a little above
  bool scales = true;                 // draws smaller when it takes too long
  bool marks = true;                  // hands, rays and forces are seen
  // Called with each picture that was submitted, and what it shows.
  std::function<void(const PlannedFrame& picture, const SceneView& view)> on_picture;
};

struct HeadsetRunSummary {
  std::string runtime, renderer;
  HeadsetDisplay::Counts counts;
  // Of a sample of the hands until the first picture of a tick that has it is seen; and what of it drawing
  // took. Medians, and what 95 of 100 stay below.
  double hand_to_picture_ms_p50 = 0, hand_to_picture_ms_p95 = 0, draw_ms_p50 = 0, draw_ms_p95 = 0;
  size_t vibrations = 0;
};

// Joins and shows the scene in a headset, whose hands pull, grab and shoot and feel what the held object
// meets. When the server goes, the scene stays as it was last and it is looked for; when the headset goes,
// that is looked for. Until the runtime ends the session, the time is up or `interrupted`.
Result<HeadsetRunSummary> run_headset(const HeadsetRunOptions& options, HeadsetDisplay& display,
                                      const std::atomic<bool>& interrupted);

std::string summary_text(const HeadsetRunSummary& summary);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "fit/fit_quantity.h"
#include "fit/point_tracks.h"
#include "fit/simulation_journal.h"
#include "scene/scene.h"
#include "splat/camera.h"
#include "splat/image.h"

// Finds physical parameters of a scene's objects from a video of their motion. Points of their surfaces are
// tracked in the video and simulated in the scene. The fitted parameters minimise the difference
// (PhysDreamer, Zhang et al. 2024; with tracks in place of pictures). The loads on the objects are known: the
// scene has them as events and motions.

namespace livegs {

struct FitRequest {
  SceneText scene;
  Camera camera;  // at rest, in the world of the scene
  // Quantities to find, by object; none: the default of the body. Empty: the only moving object.
  std::vector<std::pair<std::string, std::vector<FitQuantity>>> objects;
  double first_frame_s = 0;              // scene time of the first frame of a video
  double max_seconds = 60;               // of the recording; the rest is ignored
  SimulationJournal* journal = nullptr;  // of fit_scene(), which it must outlive
};

struct FittedValue {
  FitParameter parameter;
  double low = 0, best = 0, high = 0;  // 90 % range
  // Reduction of the uncertainty by the video, 0 to 1: 1 - variance after / variance before.
  double shown = 0;
};

struct FitResult {
  std::vector<FittedValue> values;
  std::vector<std::string> notes;  // remarks, such as undetermined quantities; one line each
  double spread_px = 0;            // robust standard deviation of a coordinate
  double spread_before_px = 0;     // the same for the prior values
  double picture_scale = 1, shift_s = 0;
  size_t simulations = 0;
  v1::Scene scene;  // with the values found; paths as in the request
  PointTracks measured, simulated;
};

// Receives a line about the current step, at least every few seconds. If it returns false, the fit stops and
// returns the best result so far.
using FitProgress = std::function<bool(const std::string& line)>;

// Tracks points of the objects in a video, from its first frame. `first_picture`, if given, receives that
// frame.
Result<PointTracks> track_video(const FitRequest& request, const std::filesystem::path& video,
                                const FitProgress& progress, Image* first_picture = nullptr);

// Points that are on none of the objects in the first frame are ignored. Fails if fewer than kMinFitPoints of
// an object remain, or if nothing moves.
inline constexpr size_t kMinFitPoints = 8;
Result<FitResult> fit_scene(const FitRequest& request, const PointTracks& tracks,
                            const FitProgress& progress);

}  // namespace livegs

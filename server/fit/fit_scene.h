// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "fit/fit_quantity.h"
#include "fit/point_tracks.h"
#include "scene/scene.h"
#include "splat/camera.h"
#include "splat/image.h"

// Finds physical parameters of a scene's objects from a video of their motion: points of their surfaces are
// tracked in the video and simulated in the scene, and the parameters are those for which both agree
// (PhysDreamer, Zhang et al. 2024; with tracks in place of pictures). What acts on the objects is known: the
// scene has it as events and motions.

namespace livegs {

struct FitRequest {
  SceneText scene;
  Camera camera;  // at rest, in the world of the scene
  // What to find, by object; no quantities: the default of the body. Empty: the only object that moves.
  std::vector<std::pair<std::string, std::vector<FitQuantity>>> objects;
  double first_frame_s = 0;  // scene time of the first frame of a video
  double max_seconds = 60;   // of the recording; the rest is left out
};

struct FittedValue {
  FitParameter parameter;
  double low = 0, best = 0, high = 0;  // 90 % range
  // Part of the uncertainty before the video that it took away, 0 to 1: 1 - variance after / variance before.
  double shown = 0;
};

struct FitResult {
  std::vector<FittedValue> values;
  std::vector<std::string> notes;  // what the video cannot tell, and other remarks; one line each
  double spread_px = 0;            // robust standard deviation of a coordinate
  double spread_before_px = 0;     // the same for the values before
  double picture_scale = 1, shift_s = 0;
  size_t simulations = 0;
  v1::Scene scene;  // with the values found; paths as in the request
  PointTracks measured, simulated;
};

// A line about what is being done, at least every few seconds. False stops: the best result so far is
// returned.
using FitProgress = std::function<bool(const std::string& line)>;

// Tracks points of the objects in a video, from its first frame. `first_picture`, if given, receives that
// frame.
Result<PointTracks> track_video(const FitRequest& request, const std::filesystem::path& video,
                                const FitProgress& progress, Image* first_picture = nullptr);

// Points that show none of the objects in the first frame are left out. Fails if fewer than kMinFitPoints of
// an object remain, or if nothing moves.
inline constexpr size_t kMinFitPoints = 8;
Result<FitResult> fit_scene(const FitRequest& request, const PointTracks& tracks,
                            const FitProgress& progress);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "fit/fit_scene.h"

namespace livegs {

// A scene whose values a fit does not see, and the recording of it.
struct HiddenMotion {
  v1::Scene truth;
  FitRequest request;  // its scene has other values
  double seconds = 1.2, frame_rate_hz = 30;
};

// A scene from JSON text.
v1::Scene scene_of(const std::string& json);

// A scene file: a soft block, held at its lower end and pushed aside once, without gravity.
std::string held_block(double modulus_pa, double spacing_m);

// Paths of `count` visible surface points of the hidden scene, without error.
PointTracks exact_tracks(const HiddenMotion& motion, size_t count);

// Normal noise on each coordinate, and a share of points that wander off: a random walk of 1.5 px a frame.
void disturb(PointTracks& tracks, double noise_px, double wrong_share, uint64_t seed);

// The result for a quantity of an object; a test failure if there is none.
FittedValue value_of(const FitResult& result, const std::string& object, FitQuantity quantity);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "core/pose.h"

namespace livegs {

// One hand at one moment, in the world frame. `active` is false if the hand is not tracked; then it holds
// nothing.
struct HandSample {
  bool active = false;
  Pose aim;              // the ray: origin, direction -Z
  Pose grip;             // the palm
  float trigger = 0.0f;  // 0..1; above 0.5 a spring along the ray holds the point that the ray first hit
  float squeeze = 0.0f;  // 0..1; above 0.5 the hand grabs
  bool shoot = false;    // the rising edge shoots one ball along the ray
};

// State of a client's controllers at one moment. Samples are numbered from 1. Each message carries the latest
// three, so a dropped message loses no button edge.
struct InputSample {
  uint64_t sequence = 0;
  int64_t sampled_ns = 0;  // time of the poses on the client's clock; several samples may have the same time
  uint64_t for_tick = 0;   // server tick that the sample is meant for; 0: the next
  std::array<HandSample, 2> hands;  // left, right
};

}  // namespace livegs

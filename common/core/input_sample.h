// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "core/pose.h"

namespace livegs {

// One hand at one moment, in the world frame. A hand that is not tracked is `active == false` and holds
// nothing.
struct HandSample {
  bool active = false;
  Pose aim;              // the ray: origin and -Z
  Pose grip;             // the palm
  float trigger = 0.0f;  // 0..1; above 0.5 the ray's spring holds the point it first met
  float squeeze = 0.0f;  // 0..1; above 0.5 the hand grabs
  bool shoot = false;    // a rising edge shoots one ball along the ray
};

// What a client's controllers did at one moment. Samples are numbered from 1 and travel three to a message,
// so that a message that is skipped loses no button edge.
struct InputSample {
  uint64_t sequence = 0;
  int64_t sampled_ns = 0;  // the moment that the poses are for, by the client's clock; several may be for one
  uint64_t for_tick = 0;   // the server's tick it is meant for; 0: the next
  std::array<HandSample, 2> hands;  // left, right
};

}  // namespace livegs

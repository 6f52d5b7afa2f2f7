// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/view_cone.h"
#include "wire/frame_stream.h"

// Which objects a frame leaves out for one client; proto/frame_format.md, "What a frame leaves out".
// Functions of what they are given alone: clients that are alike get the same.

namespace livegs {

// A ball around what an object shows now.
struct ObjectBall {
  uint32_t object_id = 0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0;
  bool asleep = false;
};
// `reach_m`: how far from its drivers it shows, as v1::ObjectDescription has it.
ObjectBall ball_around(const ObjectDrivers& drivers, double reach_m);

struct ClientView {
  std::optional<ViewCone> view;  // none: it sees everything
  std::vector<uint32_t> held;    // objects that its hands hold, ascending
  int position_bits = 16;        // of elastic objects, as it asked for when it joined
  // Neither capped nor slow: it is sent what it does not see, too, so that all who are alike in this share
  // their bytes, whichever way they look. Encoding for each by itself costs more than the bytes.
  bool uncongested = false;
};

// An object that is not seen is in one of so many ticks.
inline constexpr uint64_t kCulledUpdateInterval = 9;

// Of `balls`, those that the client does not see and whose turn it is not. Ascending ids. None that sleep,
// which cost nothing once they are sent: whoever has them shares bytes with everybody.
std::vector<uint32_t> culled(std::span<const ObjectBall> balls, const ClientView& who, uint64_t tick,
                             uint64_t tick_before);

// Of the frame's objects that may wait, those that have to if it is to take `budget_bytes` and not
// `whole_bytes`, which it takes with all that are not `out`. With those that are out; ascending ids.
std::vector<uint32_t> over_budget(const DriverFrame& frame, const StreamBaseline& baseline,
                                  std::span<const ObjectBall> balls, const ClientView& who,
                                  std::span<const uint32_t> out, double whole_bytes, double budget_bytes);

}  // namespace livegs

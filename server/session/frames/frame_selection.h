// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/view_cone.h"
#include "wire/frame_stream.h"

// Selects the objects that a frame for one client omits. In a frame over the budget, held objects are
// included first and omitted last. Others follow by visible error angle times age in ticks, per integer to
// send (bytes are in proportion); out of view it counts one eighth. New and broken objects are never omitted.
// Called by TickEncodings::for_client. See proto/frame_format.md, "Deferred objects". Pure functions: clients
// with equal views get equal frames.

namespace livegs {

// Bounding ball of the visible part of an object.
struct ObjectBall {
  uint32_t object_id = 0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0;
  bool asleep = false;
};
// `reach_m`: v1::ObjectDescription.reach_m.
ObjectBall ball_around(const ObjectDrivers& drivers, double reach_m);

struct ClientView {
  std::optional<ViewCone> view;  // none: everything is in view
  std::vector<uint32_t> held;    // ids of held objects, ascending
  int position_bits = 16;        // precision for elastic objects, requested at Join
  // Neither capped nor slow. Such a client is also sent objects outside its view, so that all uncongested
  // clients share one encoding. Separate encodings would cost more than the bytes.
  bool uncongested = false;
};

// A culled object is updated every N ticks.
inline constexpr uint64_t kCulledUpdateInterval = 9;

// The ids of objects that are outside the view and not due for an update in this tick, ascending. Sleeping
// objects are never culled: once sent they cost nothing, and clients can share bytes.
std::vector<uint32_t> culled(std::span<const ObjectBall> balls, const ClientView& who, uint64_t tick,
                             uint64_t tick_before);

// The ids of objects to omit so that the frame takes about `budget_bytes` instead of `whole_bytes`, its size
// without the objects in `out`. The result includes `out`; ascending.
std::vector<uint32_t> over_budget(const DriverFrame& frame, const StreamBaseline& baseline,
                                  std::span<const ObjectBall> balls, const ClientView& who,
                                  std::span<const uint32_t> out, double whole_bytes, double budget_bytes);

}  // namespace livegs

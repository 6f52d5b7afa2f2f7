// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "skin/driver_frame.h"

namespace livegs {

// The recent driver frames, and interpolation between them. Times are simulated time
// (DriverFrame::simulated_ns), which is independent of network jitter. Not thread-safe.
class FrameHistory {
 public:
  // `max_frames`: at least 2, which interpolation and extrapolation need.
  explicit FrameHistory(size_t max_frames) : max_frames_(max_frames) {}

  // Appends a frame; one that is not newer than the newest is ignored. The oldest is dropped when full. A
  // server omits frames while a scene rests: if the last two frames are equal and ticks are missing, the
  // newest is repeated for the tick before the new one. Returns the simulated time of that repetition.
  std::optional<int64_t> add(DriverFrame frame);

  bool empty() const { return frames_.empty(); }
  size_t size() const { return frames_.size(); }
  const DriverFrame& oldest() const { return frames_.front(); }
  const DriverFrame& newest() const { return frames_.back(); }

  // Maximum extrapolation when the next frame is late, in units of the shortest interval between frames.
  static constexpr int64_t kFramesAhead = 2;

  // Interpolates the two frames around the time: positions linearly, rotations by normalised lerp along the
  // shorter arc. Times before the oldest frame give the poses of that frame. After the newest, motion is
  // extrapolated from the last two frames for up to kFramesAhead intervals and then stops. An object that is
  // only in the later frame is omitted; one that is only in the earlier frame is kept until the later. A
  // fractured object stays whole until the later frame. Returns nullopt while the history is empty.
  std::optional<DriverFrame> at(int64_t simulated_ns) const;
  // Drops frames that at(t) does not need for t >= simulated_ns.
  void drop_before(int64_t simulated_ns);

 private:
  void push(DriverFrame frame);
  int64_t shortest_ns() const;

  size_t max_frames_;
  std::deque<DriverFrame> frames_;
};

// Whether all objects have the same drivers, to the bit. False for frames of kernels.
bool same_drivers(const DriverFrame& a, const DriverFrame& b);
// Interpolates from a to b; `share` in 0..1. Kernels, and objects whose kind, revision or count differ, are
// copied from a.
DriverFrame interpolate(const DriverFrame& a, const DriverFrame& b, double share);
// Extrapolates beyond b; `share` >= 1 is measured from a. Kernels, and objects that sleep in b, are missing
// in a, or differ in kind, revision or count, are copied from b.
DriverFrame extrapolate(const DriverFrame& a, const DriverFrame& b, double share);

}  // namespace livegs

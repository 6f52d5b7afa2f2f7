// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "skin/driver_frame.h"

namespace livegs {

// The driver frames of the recent past, and the drivers of any moment between them. Moments are simulated
// time (DriverFrame::simulated_ns), which runs evenly however the network delivers. Not locked.
class FrameHistory {
 public:
  explicit FrameHistory(size_t max_frames) : max_frames_(max_frames) {}

  // Frames come in order; one that is not newer than the newest is ignored. The oldest makes room.
  void add(DriverFrame frame);

  bool empty() const { return frames_.empty(); }
  size_t size() const { return frames_.size(); }
  const DriverFrame& oldest() const { return frames_.front(); }
  const DriverFrame& newest() const { return frames_.back(); }

  // How far things go on as they moved when the next frame is late, in the shortest interval between frames.
  static constexpr int64_t kFramesAhead = 2;

  // Positions are interpolated linearly, rotations by normalised lerp along the shorter way, between the two
  // frames around the moment. Before the oldest that stands still; after the newest things go on as between
  // the last two for at most kFramesAhead, and then stand. An object that is in the later frame only has not
  // come yet; one in the earlier only is there until the later; one that broke between the two is whole until
  // the later, and stands after it. Nothing while empty.
  std::optional<DriverFrame> at(int64_t simulated_ns) const;
  // Drops frames that at(t) for t >= simulated_ns does not need.
  void drop_before(int64_t simulated_ns);

 private:
  int64_t shortest_ns() const;

  size_t max_frames_;
  std::deque<DriverFrame> frames_;
};

// `share` of the way from a to b, 0..1. Objects whose kind, revision or count differ, and kernels, are taken
// from a.
DriverFrame interpolate(const DriverFrame& a, const DriverFrame& b, double share);
// Beyond b, `share` of the way from a, 1 or more. Objects that sleep in b, or whose kind, revision or count
// differ, or that a has not, and kernels, stand as in b.
DriverFrame extrapolate(const DriverFrame& a, const DriverFrame& b, double share);

}  // namespace livegs

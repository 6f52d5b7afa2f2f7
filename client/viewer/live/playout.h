// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "stream/received/frame_history.h"
#include "stream/received/received.h"
#include "stream/time/playout_clock.h"

namespace livegs {

// Frames of a live stream, interpolated for display slightly behind the newest, at an even rate. One thread.
class Playout {
 public:
  // Frames in order of arrival.
  void add(ReceivedFrame frame);
  // Discards all state after a server restart.
  void reset() { *this = Playout(); }

  // Drivers of a picture that is drawn now and displayed at `displayed_ns` (now_ns() time). Nothing before
  // the first frame.
  std::optional<DriverFrame> at(int64_t now_ns, int64_t displayed_ns);
  // The newest frame that the last at() had reached; its hand states match that picture. Null before at().
  const ReceivedFrame* shown() const { return shown_ ? &*shown_ : nullptr; }
  // Whether the last at() had reached the newest change of the drivers, so that later calls return the same.
  bool settled() const { return moment_ns_ >= changed_ns_; }

 private:
  static constexpr size_t kFramesKept = 64;
  FrameHistory history_{kFramesKept};
  PlayoutClock clock_;
  std::deque<ReceivedFrame> waiting_;  // later than the last at()
  std::optional<ReceivedFrame> shown_;
  int64_t changed_ns_ = 0;  // simulated time of the newest frame that differs from the one before it
  int64_t moment_ns_ = 0;   // of the last at()
};

}  // namespace livegs

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

 private:
  static constexpr size_t kFramesKept = 64;
  FrameHistory history_{kFramesKept};
  PlayoutClock clock_;
  std::deque<ReceivedFrame> waiting_;  // later than the last at()
  std::optional<ReceivedFrame> shown_;
};

}  // namespace livegs

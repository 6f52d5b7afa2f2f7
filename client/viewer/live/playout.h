// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "stream/received/frame_history.h"
#include "stream/received/received.h"
#include "stream/time/playout_clock.h"

namespace livegs {

// The frames of a live stream, and what a picture of it shows: a moment shortly before the newest, that
// advances as evenly as the display. One thread.
class Playout {
 public:
  // In the order they came.
  void add(ReceivedFrame frame);
  // What comes next has nothing to do with what came: a server that was started anew.
  void reset() { *this = Playout(); }

  // The drivers of a picture that is drawn now and seen then, by now_ns(). Nothing before the first frame.
  std::optional<DriverFrame> at(int64_t now_ns, int64_t displayed_ns);
  // The newest frame that the last at() had reached: what its hands held was true at that moment. Null before
  // at().
  const ReceivedFrame* shown() const { return shown_ ? &*shown_ : nullptr; }

 private:
  static constexpr size_t kFramesKept = 64;
  FrameHistory history_{kFramesKept};
  PlayoutClock clock_;
  std::deque<ReceivedFrame> waiting_;  // not reached yet
  std::optional<ReceivedFrame> shown_;
};

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "stream/received/frame_history.h"
#include "stream/time/playout_clock.h"

namespace livegs {

// Frames of a live stream, interpolated for display slightly behind the newest, at an even rate. One thread.
// A Frame has `drivers`, a pointer to its DriverFrame that is not null, and `received_ns` on the client's
// clock.
template <class Frame>
class FramePlayout {
 public:
  // Frames in order of arrival.
  void add(Frame frame) {
    const DriverFrame& drivers = *frame.drivers;
    const bool changes = history_.empty() || !same_drivers(history_.newest(), drivers);
    const auto repeated_ns = history_.add(drivers);
    clock_.arrived(drivers.simulated_ns, frame.received_ns, repeated_ns);
    if (changes) changed_ns_ = drivers.simulated_ns;
    waiting_.push_back(std::move(frame));
    if (waiting_.size() > kFramesKept) waiting_.pop_front();
  }
  // Discards all state after a server restart.
  void reset() { *this = FramePlayout(); }

  // Drivers of a picture that is drawn now and displayed at `displayed_ns` (now_ns() time). Nothing before
  // the first frame.
  std::optional<DriverFrame> at(int64_t now_ns, int64_t displayed_ns) {
    if (history_.empty()) return std::nullopt;
    const int64_t moment_ns = moment_ns_ = clock_.at(now_ns, displayed_ns);
    while (!waiting_.empty() && (!shown_ || waiting_.front().drivers->simulated_ns <= moment_ns)) {
      shown_ = std::move(waiting_.front());
      waiting_.pop_front();
    }
    return history_.at(moment_ns);
  }
  // The newest frame that the last at() had reached; its hand states match that picture. Null before at().
  const Frame* shown() const { return shown_ ? &*shown_ : nullptr; }
  // Whether the last at() had reached the newest change of the drivers, so that later calls return the same.
  bool settled() const { return moment_ns_ >= changed_ns_; }

 private:
  static constexpr size_t kFramesKept = 64;
  FrameHistory history_{kFramesKept};
  PlayoutClock clock_;
  std::deque<Frame> waiting_;  // later than the last at()
  std::optional<Frame> shown_;
  int64_t changed_ns_ = 0;  // simulated time of the newest frame that differs from the one before it
  int64_t moment_ns_ = 0;   // of the last at()
};

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace livegs {

// Chooses the server tick for an input sample that is sent now, so that all samples have the same latency
// despite network jitter: the first tick that begins after 95 % of such messages have arrived. On a quiet
// network this is the next tick. Not thread-safe.
class TickAim {
 public:
  explicit TickAim(double rate_hz) : rate_hz_(rate_hz) {}

  // The tick of a received frame and its start by the server's clock; the next tick begins one period later.
  void add_frame(uint64_t tick, int64_t begun_ns);
  // A message sent at `sent_ns` (client clock) was received at `received_ns` (server clock).
  void arrived(int64_t sent_ns, int64_t received_ns);

  // 0 ("the next tick") while the travel time is unknown or the result would exceed kMaxTicksAhead.
  uint64_t tick_at(int64_t now_ns) const;

 private:
  static constexpr size_t kArrivalsKept = 64;
  static constexpr double kArrivalShare = 0.95;
  static constexpr int64_t kMaxTicksAhead = 15;  // the server accepts 30

  const double rate_hz_;
  uint64_t tick_ = 0;
  int64_t begun_ns_ = 0;  // start of that tick, server clock
  // Received minus sent, of the newest arrivals: travel time plus clock offset.
  std::deque<int64_t> upward_ns_;
};

}  // namespace livegs

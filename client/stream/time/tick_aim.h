// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace livegs {

// Which tick of the server a sample of hands that is sent now should be meant for, so that each is applied as
// long after it was taken as the others, though the network delivers them unevenly: the first tick that
// begins after 95 of 100 such messages have arrived. On a quiet network that is the next one. Not locked.
class TickAim {
 public:
  explicit TickAim(double rate_hz) : rate_hz_(rate_hz) {}

  // The tick of a frame that was received and when it began, by the server's clock; the next begins a period
  // later.
  void add_frame(uint64_t tick, int64_t begun_ns);
  // A message that was sent then has arrived then, the one by this clock, the other by the server's.
  void arrived(int64_t sent_ns, int64_t heard_ns);

  // 0, for "the next", while the clock or the way is not known, or would ask for more than kMaxTicksAhead.
  uint64_t tick_at(int64_t now_ns) const;

 private:
  static constexpr size_t kArrivalsKept = 64;
  static constexpr double kArrivalShare = 0.95;
  static constexpr int64_t kMaxTicksAhead = 15;  // the server believes 30

  const double rate_hz_;
  uint64_t tick_ = 0;
  int64_t begun_ns_ = 0;           // when that tick began, the server's clock
  std::deque<int64_t> upward_ns_;  // heard - sent of the newest arrivals: travel and offset together
};

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace livegs {

// When to report to a supervisor that the simulation runs: once an interval, and only if ticks advanced since
// the last report. Therefore the last report is at most one interval later than a stuck tick, whatever else
// of the process still runs. One thread at a time.
class TickLiveness {
 public:
  // `interval_ns`: between reports; 0 or less: none is due.
  explicit TickLiveness(int64_t interval_ns) : interval_ns_(interval_ns) {}

  // Whether a report is due. `ticks`: so far, of the simulation; never of the caller's own thread.
  bool due(uint64_t ticks, int64_t now_ns) {
    if (interval_ns_ <= 0 || now_ns - reported_ns_ < interval_ns_ || ticks == reported_ticks_) return false;
    reported_ns_ = now_ns;
    reported_ticks_ = ticks;
    return true;
  }

 private:
  int64_t interval_ns_ = 0, reported_ns_ = 0;
  uint64_t reported_ticks_ = 0;
};

}  // namespace livegs

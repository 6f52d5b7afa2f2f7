// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>

#include "livegs/v1/recording.pb.h"
#include "livegs/v1/session.pb.h"
#include "recording/tick_record.h"

namespace livegs {

// Simulated time of a tick without a frame.
int64_t tick_time_ns(uint64_t tick, double rate_hz);

// Counts the content of a recording while it is written or read. Not thread-safe.
class RecordingCount {
 public:
  void take(const v1::SessionEvent& event);
  // `simulated_ns`: time of the frame, or the time it would have. Ticks before the first key tick are not
  // part of the recording.
  void take(const TickRecord& record, int64_t simulated_ns);
  const v1::RecordingTotals& totals() const { return totals_; }

 private:
  v1::RecordingTotals totals_;
  std::map<uint32_t, uint32_t> revisions_;  // of existing objects
};

}  // namespace livegs

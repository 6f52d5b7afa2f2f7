// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>

#include "livegs/v1/recording.pb.h"
#include "livegs/v1/session.pb.h"
#include "recording/tick_record.h"

namespace livegs {

// Where a tick without a frame stands in simulated time.
int64_t tick_time_ns(uint64_t tick, double rate_hz);

// Counts what goes by, while it is written or read. Not locked.
class RecordingCount {
 public:
  void take(const v1::SessionEvent& event);
  // `simulated_ns`: of its frame, or where it would be. Ticks before the first key tick lie before the
  // recording.
  void take(const TickRecord& record, int64_t simulated_ns);
  const v1::RecordingTotals& totals() const { return totals_; }

 private:
  v1::RecordingTotals totals_;
  std::map<uint32_t, uint32_t> revisions_;  // of objects that are there
};

}  // namespace livegs

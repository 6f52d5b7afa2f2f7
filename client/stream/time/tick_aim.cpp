// SPDX-License-Identifier: Apache-2.0
#include "stream/time/tick_aim.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace livegs {

void TickAim::add_frame(uint64_t tick, int64_t begun_ns) {
  tick_ = tick;
  begun_ns_ = begun_ns;
}

void TickAim::arrived(int64_t sent_ns, int64_t received_ns) {
  upward_ns_.push_back(received_ns - sent_ns);
  if (upward_ns_.size() > kArrivalsKept) upward_ns_.pop_front();
}

uint64_t TickAim::tick_at(int64_t now_ns) const {
  if (upward_ns_.empty() || tick_ == 0 || !(rate_hz_ > 0)) return 0;
  std::vector<int64_t> upward(upward_ns_.begin(), upward_ns_.end());
  const auto rank =
      upward.begin() + static_cast<std::ptrdiff_t>(kArrivalShare * static_cast<double>(upward.size() - 1));
  std::nth_element(upward.begin(), rank, upward.end());
  // The clock offset is included in both the samples and the result, so it need not be known.
  const double periods = 1e-9 * static_cast<double>(now_ns + *rank - begun_ns_) * rate_hz_;
  const double ahead = std::max(1.0, std::ceil(periods));
  return ahead <= kMaxTicksAhead ? tick_ + static_cast<uint64_t>(ahead) : 0;
}

}  // namespace livegs

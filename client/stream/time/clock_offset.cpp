// SPDX-License-Identifier: Apache-2.0
#include "stream/time/clock_offset.h"

#include <algorithm>

namespace livegs {
namespace {

// Bounds that contradict each other by more than this indicate a clock adjustment or a suspended machine.
constexpr int64_t kMaxBoundContradiction_ns = 1'000'000;

}  // namespace

int64_t ClockOffset::loosened(const Bound& bound, int64_t client_ns) {
  return bound.value_ns + static_cast<int64_t>(kMaxDrift * static_cast<double>(client_ns - bound.client_ns));
}

void ClockOffset::tighten(Bounds& bounds, const Bound& bound) {
  while (!bounds.empty() && loosened(bounds.back(), bound.client_ns) >= bound.value_ns) bounds.pop_back();
  bounds.push_back(bound);
  while (bound.client_ns - bounds.front().client_ns > kWindow_ns) bounds.pop_front();
}

void ClockOffset::add(const ClockSample& sample) {
  const Bound up{sample.sent_ns, sample.server_received_ns - sample.sent_ns};
  const Bound down{sample.received_ns, sample.received_ns - sample.server_sent_ns};
  if (const auto known = at(sample.received_ns)) {
    const int64_t upper_ns = known->offset_ns + known->uncertainty_ns;
    const int64_t lower_ns = known->offset_ns - known->uncertainty_ns;
    if (up.value_ns < lower_ns - kMaxBoundContradiction_ns ||
        -down.value_ns > upper_ns + kMaxBoundContradiction_ns) {
      upper_.clear();
      lower_.clear();
    }
  }
  tighten(upper_, up);
  tighten(lower_, down);
}

std::optional<ClockOffset::Estimate> ClockOffset::at(int64_t client_ns) const {
  if (upper_.empty() || lower_.empty()) return std::nullopt;
  const int64_t upper_ns = loosened(upper_.front(), client_ns),
                lower_ns = -loosened(lower_.front(), client_ns);
  return Estimate{(upper_ns + lower_ns) / 2, std::max<int64_t>(0, (upper_ns - lower_ns) / 2)};
}

}  // namespace livegs

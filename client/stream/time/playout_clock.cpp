// SPDX-License-Identifier: Apache-2.0
#include "stream/time/playout_clock.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/percentile.h"

namespace livegs {
namespace {

constexpr int64_t kMinRateSpan_ns = 1'000'000'000;  // shortest span for a rate estimate
constexpr double kRateNoise = 0.05;                 // rate error caused by jitter
constexpr double kCorrection_ns = 400e6;            // time constant of the error correction

}  // namespace

void PlayoutClock::arrived(int64_t simulated_ns, int64_t received_ns, std::optional<int64_t> held_until_ns) {
  const bool stands = !arrivals_.empty() && simulated_ns <= arrivals_.back().simulated_ns;
  const bool silent = !arrivals_.empty() && received_ns - arrivals_.back().received_ns > kSilenceTimeout_ns;
  if (stands || silent) arrivals_.clear();
  const int64_t before_ns = arrivals_.empty() ? simulated_ns : arrivals_.back().simulated_ns;
  arrivals_.push_back({simulated_ns, received_ns, held_until_ns.value_or(before_ns)});
  while (arrivals_.front().received_ns < received_ns - kWindow_ns) arrivals_.pop_front();
}

double PlayoutClock::rate() const {
  if (arrivals_.empty()) return 1;
  const Arrival &first = arrivals_.front(), &last = arrivals_.back();
  const auto passed = static_cast<double>(last.received_ns - first.received_ns);
  if (passed < kMinRateSpan_ns) return 1;
  const double rate = static_cast<double>(last.simulated_ns - first.simulated_ns) / passed;
  return std::abs(rate - 1) < kRateNoise ? 1 : std::clamp(rate, 0.01, 4.0);
}

double PlayoutClock::wanted_ns(int64_t drawn_ns) const {
  if (arrivals_.size() < 2) return 0;
  const Arrival& newest = arrivals_.back();
  const double rate = this->rate();
  // Time since the arrival that, at an even rate, corresponds to the simulated time; relative to the newest
  // frame.
  const auto late = [&](int64_t received_ns, int64_t simulated_ns) {
    return static_cast<double>(received_ns - newest.received_ns) -
           static_cast<double>(simulated_ns - newest.simulated_ns) / rate;
  };
  std::vector<double> needed, intervals;
  double quickest = late(newest.received_ns, newest.simulated_ns);
  for (size_t i = 1; i < arrivals_.size(); ++i) {
    needed.push_back(late(arrivals_[i].received_ns, arrivals_[i].held_until_ns));
    quickest = std::min(quickest, late(arrivals_[i].received_ns, arrivals_[i].simulated_ns));
  }
  const double delay =
      std::min(percentile(std::move(needed), kOnTimeShare), quickest + static_cast<double>(kMaxJitter_ns));
  return rate * (static_cast<double>(drawn_ns - newest.received_ns) - delay);
}

int64_t PlayoutClock::at(int64_t now_ns, int64_t displayed_ns) {
  if (arrivals_.empty()) return 0;
  leads_ns_.push_back(displayed_ns - now_ns);
  if (leads_ns_.size() > kLeadsKept) leads_ns_.pop_front();
  // The frames of a picture must be available when it is drawn, which is `lead` before it is displayed.
  const int64_t lead = percentile(std::vector<int64_t>(leads_ns_.begin(), leads_ns_.end()), kOnTimeShare);
  const int64_t drawn_ns = displayed_ns - lead;
  const auto newest = static_cast<double>(arrivals_.back().simulated_ns);
  const double passed = rate() * static_cast<double>(std::max<int64_t>(0, drawn_ns - last_drawn_ns_));
  const double error = newest + wanted_ns(drawn_ns) - (shown_ns_ + passed);
  const bool jumps = !shows_ || std::abs(error) > static_cast<double>(kMaxPlayoutError_ns);
  shown_ns_ += jumps
                   ? passed + error
                   : passed * (1 + std::clamp(error / kCorrection_ns, -kMaxRateDeviation, kMaxRateDeviation));
  if (arrivals_.size() < 2) shown_ns_ = std::min(shown_ns_, newest);
  shows_ = true;
  last_drawn_ns_ = std::max(last_drawn_ns_, drawn_ns);
  return static_cast<int64_t>(shown_ns_);
}

}  // namespace livegs

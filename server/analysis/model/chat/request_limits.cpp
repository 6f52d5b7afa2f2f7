// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/request_limits.h"

#include <algorithm>
#include <cmath>

namespace livegs {

bool CircuitBreaker::try_pass(std::int64_t now_ns) {
  if (!opened_) return true;
  if (now_ns < until_ns_ || probing_) return false;
  probing_ = true;
  return true;
}

void CircuitBreaker::succeed() {
  opened_ = probing_ = false;
  failures_ = 0;
  reason_.clear();
}

void CircuitBreaker::fail(std::int64_t now_ns, const std::string& reason) {
  ++failures_;
  if (probing_ || failures_ >= limit_) open(now_ns, open_s_, reason);
}

void CircuitBreaker::open(std::int64_t now_ns, double open_s, const std::string& reason) {
  opened_ = true;
  probing_ = false;
  until_ns_ = now_ns + static_cast<std::int64_t>(open_s * 1e9);
  reason_ = reason;
}

double CircuitBreaker::seconds_left(std::int64_t now_ns) const {
  return opened_ ? std::max(0.0, static_cast<double>(until_ns_ - now_ns) * 1e-9) : 0.0;
}

double backoff_s(int attempt, double base_s, double cap_s, double unit, double retry_after_s) {
  const double window_s = std::min(cap_s, base_s * std::exp2(std::min(attempt, 30)));
  return std::max(window_s * unit, retry_after_s);
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace livegs {

// A token bucket. It starts full, refills at a constant rate up to its capacity, and is charged for each
// admitted item. Times are from now_ns(); a time before the last one adds nothing. Not thread-safe.
class TokenBucket {
 public:
  TokenBucket(double rate_per_s, double capacity)
      : rate_per_s_(rate_per_s), capacity_(capacity), tokens_(capacity) {}

  // Keeps the current tokens, up to the new capacity.
  void set_rate(double rate_per_s, double capacity) {
    rate_per_s_ = rate_per_s;
    capacity_ = capacity;
    tokens_ = filled_ns_ == kNever ? capacity : std::min(tokens_, capacity);
  }

  // The tokens at `now_ns`; a negative number is a debt.
  double refill(int64_t now_ns) {
    if (filled_ns_ != kNever) {
      const double elapsed_s = static_cast<double>(std::max<int64_t>(0, now_ns - filled_ns_)) * 1e-9;
      tokens_ = std::min(capacity_, tokens_ + elapsed_s * rate_per_s_);
    }
    filled_ns_ = std::max(filled_ns_, now_ns);
    return tokens_;
  }
  // Charges tokens; the balance may become negative.
  void pay(double tokens) { tokens_ -= tokens; }

  // Charges one token. Returns false, and charges nothing, if none is available.
  bool try_take(int64_t now_ns) {
    if (refill(now_ns) < 1) return false;
    pay(1);
    return true;
  }
  // Charges one token, into debt if necessary. Returns the nanoseconds until the debt is paid off.
  int64_t take_in_debt(int64_t now_ns) {
    refill(now_ns);
    pay(1);
    return tokens_ >= 0 ? 0 : static_cast<int64_t>(-tokens_ / rate_per_s_ * 1e9);
  }

 private:
  static constexpr int64_t kNever = std::numeric_limits<int64_t>::min();

  double rate_per_s_, capacity_, tokens_;
  int64_t filled_ns_ = kNever;
};

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace livegs {

// Token bucket: an account that starts full, grows at a rate up to its capacity and pays for what passes.
// Times are of now_ns(); a time before the last one adds nothing. Not locked.
class TokenBucket {
 public:
  TokenBucket(double rate_per_s, double capacity)
      : rate_per_s_(rate_per_s), capacity_(capacity), tokens_(capacity) {}

  // Keeps the tokens saved so far, up to the new capacity.
  void set_rate(double rate_per_s, double capacity) {
    rate_per_s_ = rate_per_s;
    capacity_ = capacity;
    tokens_ = filled_ns_ == kNever ? capacity : std::min(tokens_, capacity);
  }

  // The tokens at `now_ns`; negative: a debt.
  double refill(int64_t now_ns) {
    if (filled_ns_ != kNever) {
      const double elapsed_s = static_cast<double>(std::max<int64_t>(0, now_ns - filled_ns_)) * 1e-9;
      tokens_ = std::min(capacity_, tokens_ + elapsed_s * rate_per_s_);
    }
    filled_ns_ = std::max(filled_ns_, now_ns);
    return tokens_;
  }
  // Pays, into debt if need be.
  void pay(double tokens) { tokens_ -= tokens; }

  // Pays one token. False if there is none, at no cost.
  bool try_take(int64_t now_ns) {
    if (refill(now_ns) < 1) return false;
    pay(1);
    return true;
  }
  // Pays one token, into debt if need be. Returns the nanoseconds until the debt is paid off.
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

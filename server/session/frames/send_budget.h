// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>

#include "core/token_bucket.h"

namespace livegs {

// What a stream may still take; proto/frame_format.md, "What a frame leaves out". An account that grows by
// the cap and pays for every message: any stretch of T seconds carries at most cap * (T + kBurst_s) bytes and
// one message more. Not locked.
class SendBudget {
 public:
  // What is not used is kept for so long: frames of a sudden motion may be larger than those of rest.
  static constexpr double kBurst_s = 0.1;

  // Bytes a second; infinity: no cap. What was saved goes on.
  void set_cap(double bytes_s) {
    cap_bytes_s_ = bytes_s;
    bytes_.set_rate(bytes_s, bytes_s * kBurst_s);
  }
  bool capped() const { return cap_bytes_s_ < std::numeric_limits<double>::infinity(); }

  // What may be sent now; 0 or less: nothing.
  double available_bytes(int64_t now_ns) {
    return capped() ? bytes_.refill(now_ns) : std::numeric_limits<double>::infinity();
  }
  void pay(double bytes) {
    if (capped()) bytes_.pay(bytes);
  }

 private:
  double cap_bytes_s_ = std::numeric_limits<double>::infinity();
  TokenBucket bytes_{cap_bytes_s_, cap_bytes_s_};
};

}  // namespace livegs

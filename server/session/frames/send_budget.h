// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>

#include "core/token_bucket.h"

namespace livegs {

// Bandwidth limit of one stream; see proto/frame_format.md, "Deferred objects". A token bucket: any T
// seconds carry at most cap * (T + kBurst_s) bytes plus one message. Not locked.
class SendBudget {
 public:
  // Unused budget accumulates for this time, since frames of a sudden motion are larger than frames at rest.
  static constexpr double kBurst_s = 0.1;

  // Bytes a second; infinity: no cap. The accumulated budget is kept.
  void set_cap(double bytes_s) {
    cap_bytes_s_ = bytes_s;
    bytes_.set_rate(bytes_s, bytes_s * kBurst_s);
  }
  bool capped() const { return cap_bytes_s_ < std::numeric_limits<double>::infinity(); }

  // Bytes that may be sent now; nothing if 0 or less.
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

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace livegs {

// What a stream may still take; proto/frame_format.md, "What a frame leaves out". An account that grows by the cap and pays
// for every message: any stretch of T seconds carries at most cap * (T + kSaved_s) bytes and one message more. Not locked.
class SendBudget {
 public:
  // What is not used is kept for so long: frames of a sudden motion may be larger than those of rest.
  static constexpr double kSaved_s = 0.1;

  // Bytes a second; infinity: no cap. What was saved goes on.
  void set_cap(double bytes_s) {
    cap_bytes_s_ = bytes_s;
    bytes_ = std::min(bytes_, most_bytes());
  }
  bool capped() const { return cap_bytes_s_ < std::numeric_limits<double>::infinity(); }

  // What may be sent now; 0 or less: nothing.
  double available_bytes(int64_t now_ns) {
    if (!capped()) return std::numeric_limits<double>::infinity();
    if (at_ns_ == 0) at_ns_ = now_ns, bytes_ = most_bytes();
    bytes_ = std::min(most_bytes(), bytes_ + cap_bytes_s_ * 1e-9 * static_cast<double>(std::max<int64_t>(0, now_ns - at_ns_)));
    at_ns_ = std::max(at_ns_, now_ns);
    return bytes_;
  }
  void pay(double bytes) {
    if (capped()) bytes_ -= bytes;
  }

 private:
  double most_bytes() const { return cap_bytes_s_ * kSaved_s; }

  double cap_bytes_s_ = std::numeric_limits<double>::infinity();
  double bytes_ = 0;
  int64_t at_ns_ = 0;  // 0: nothing was asked yet
};

}  // namespace livegs

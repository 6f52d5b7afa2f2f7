// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>

namespace livegs {

// So many a second, and so many at once after a rest (a leaky bucket). Not locked.
class RateLimit {
 public:
  RateLimit(double per_second, double at_once) : per_second_(per_second), at_once_(at_once), left_(at_once) {}

  // False when it is one too many, which does not count. `now_ns` of now_ns(), never going back.
  bool take(int64_t now_ns) {
    if (taken_ns_ != 0) {
      left_ = std::min(at_once_, left_ + static_cast<double>(now_ns - taken_ns_) * 1e-9 * per_second_);
    }
    taken_ns_ = now_ns;
    if (left_ < 1) return false;
    left_ -= 1;
    return true;
  }

 private:
  double per_second_, at_once_, left_;
  int64_t taken_ns_ = 0;
};

}  // namespace livegs

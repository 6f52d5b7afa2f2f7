// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace livegs {

// How much smaller than its window a picture is drawn, so that it is drawn in time. Cost is taken to go with
// the number of pixels; steps of an eighth, and a dead zone, keep the size from flickering.
class RenderScale {
 public:
  explicit RenderScale(double budget_ms) : budget_ms_(budget_ms) {}

  // After a picture that took so long.
  void drew(double ms) {
    if (ms > 0.7 * budget_ms_ && ms < budget_ms_) return;
    wanted_ = std::clamp(wanted_ * std::clamp(std::sqrt(0.85 * budget_ms_ / std::max(ms, 1e-3)), 0.7, 1.1),
                         0.25, 1.0);
  }

  double value() const { return std::max(0.25, std::floor(8.0 * wanted_ + 1e-9) / 8.0); }  // 0.25..1
  int of(int pixels) const { return std::max(16, static_cast<int>(std::lround(value() * pixels))); }

 private:
  double budget_ms_;
  double wanted_ = 1.0;
};

}  // namespace livegs

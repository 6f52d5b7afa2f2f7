// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace livegs {

// What a window's picture may take, by the refreshes a second of its monitor (0: not known, taken for 60):
// nine tenths of two refreshes, 30 ms at 60 Hz. No less than 8 ms, of which a picture's way through main
// memory alone takes some, and no more than 40, beyond which a slow monitor hides less than a slow hand sees.
inline double window_budget_ms(double refresh_hz) {
  return std::clamp(0.9 * 2000.0 / (refresh_hz > 0 ? refresh_hz : 60.0), 8.0, 40.0);
}

// Of pictures that are drawn at full size however long they take.
inline constexpr double kUnlimitedBudget_ms = std::numeric_limits<double>::infinity();

// How much smaller than its window a picture is drawn, and which kernels are left out of it, so that it is
// drawn in time. Cost is taken to go with the number of pixels; steps of an eighth, and a dead zone, keep the
// size from flickering. Both go together: at half the size, kernels that add less than a pixel of the window
// are left out, at a quarter, the least size, less than three, and never more than four: that leaves captured
// assets 34 dB and more, which is no less than the size does. Beyond that pictures are late rather than
// empty: where each of a million kernels adds little, a threshold that went on would leave out all of them.
class RenderScale {
 public:
  explicit RenderScale(double budget_ms) : budget_ms_(budget_ms) {}

  // After a picture that took so long.
  void drew(double ms) {
    if (ms > 0.7 * budget_ms_ && ms < budget_ms_) return;
    const double next = std::clamp(
        wanted_ * std::clamp(std::sqrt(0.85 * budget_ms_ / std::max(ms, 1e-3)), 0.7, 1.1), kMinScale, 1.0);
    // A step from 3/8 to 1/2 is more than the dead zone: it is taken if it will do, or sizes would alternate.
    const double step = size(next) / value();
    if (step > 1.0 && ms * step * step > 0.95 * budget_ms_) return;
    wanted_ = next;
  }

  double value() const { return size(wanted_); }  // 0.25..1
  int of(int pixels) const { return std::max(16, static_cast<int>(std::lround(value() * pixels))); }
  // As RenderOptions has it, in pixels of the smaller picture: 0 while pictures are in time.
  float min_contribution_px() const { return static_cast<float>(value() * value() * (1.0 / wanted_ - 1.0)); }

 private:
  static constexpr double kMinScale = 0.2;
  static double size(double wanted) { return std::max(0.25, std::floor(8.0 * wanted + 1e-9) / 8.0); }
  double budget_ms_;
  double wanted_ = 1.0;
};

}  // namespace livegs

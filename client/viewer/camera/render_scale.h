// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace livegs {

// Time budget of a window's picture for the monitor's refresh rate (0: unknown, 60 Hz is assumed): nine
// tenths of two refreshes, 30 ms at 60 Hz. At least 8 ms, since the copy through main memory takes part of
// it, and at most 40 ms, to stay responsive on slow monitors.
inline double window_budget_ms(double refresh_hz) {
  return std::clamp(0.9 * 2000.0 / (refresh_hz > 0 ? refresh_hz : 60.0), 8.0, 40.0);
}

// Budget for pictures that are always drawn at full size.
inline constexpr double kUnlimitedBudget_ms = std::numeric_limits<double>::infinity();

// Chooses the size of a picture relative to its window, and the contribution threshold of its kernels, to
// stay within the budget. Cost is assumed proportional to the number of pixels. Steps of an eighth and a dead
// zone prevent flicker. The threshold grows with the reduction: one pixel of the window at half the size,
// three at a quarter (the minimum), and at most four. A higher threshold would remove all kernels of assets
// with many small ones, so pictures are late instead.
class RenderScale {
 public:
  explicit RenderScale(double budget_ms) : budget_ms_(budget_ms) {}

  // Records a picture that took this long.
  void drew(double ms) {
    if (ms > 0.7 * budget_ms_ && ms < budget_ms_) return;
    const double next = std::clamp(
        wanted_ * std::clamp(std::sqrt(0.85 * budget_ms_ / std::max(ms, 1e-3)), 0.7, 1.1), kMinScale, 1.0);
    // The step from 3/8 to 1/2 exceeds the dead zone; it is taken only if it fits, to avoid oscillation.
    const double step = size(next) / value();
    if (step > 1.0 && ms * step * step > 0.95 * budget_ms_) return;
    wanted_ = next;
  }

  double value() const { return size(wanted_); }  // 0.25..1
  int of(int pixels) const { return std::max(16, static_cast<int>(std::lround(value() * pixels))); }
  // As in RenderOptions, in pixels of the reduced picture; 0 while pictures are on time.
  float min_contribution_px() const { return static_cast<float>(value() * value() * (1.0 / wanted_ - 1.0)); }

 private:
  static constexpr double kMinScale = 0.2;
  static double size(double wanted) { return std::max(0.25, std::floor(8.0 * wanted + 1e-9) / 8.0); }
  double budget_ms_;
  double wanted_ = 1.0;
};

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace livegs {

// Percentiles of positive values in constant memory (12 kB). Bins are 2 % wide, from 1e-4 to 1e9. The result
// is the geometric middle of a bin, so it is within 1 % of a recorded value. Not locked.
class DurationHistogram {
 public:
  void add(double value) {
    if (!(value >= 0)) return;
    const double bin = value <= kMinValue ? 0.0 : std::log(value / kMinValue) / std::log(kRatio);
    ++bins_[std::min(static_cast<size_t>(bin), kBins - 1)];
    ++count_;
    sum_ += value;
    largest_ = std::max(largest_, value);
  }

  // `share` is in 0..1. Returns 0 if there are no values.
  double percentile(double share) const {
    const uint64_t rank = static_cast<uint64_t>(share * static_cast<double>(count_));
    uint64_t seen = 0;
    for (size_t i = 0; i < kBins; ++i) {
      seen += bins_[i];
      if (seen > rank) return std::min(largest_, kMinValue * std::pow(kRatio, static_cast<double>(i) + 0.5));
    }
    return largest_;
  }
  uint64_t count() const { return count_; }
  double sum() const { return sum_; }
  double largest() const { return largest_; }

 private:
  static constexpr double kMinValue = 1e-4;
  static constexpr double kRatio = 1.02;
  static constexpr size_t kBins = 1512;  // ln(1e13) / ln(1.02)
  std::array<uint64_t, kBins> bins_{};
  uint64_t count_ = 0;
  double sum_ = 0;
  double largest_ = 0;
};

}  // namespace livegs

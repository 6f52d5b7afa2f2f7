// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <numbers>

namespace livegs {

// The standard normal distribution truncated to values below `end`.
struct TruncatedNormal {
  double mass = 1.0;      // fraction of the whole, 0 … 1
  double mean = 0.0;      // negative
  double variance = 1.0;  // 0 … 1
};

// With h = p(end) / P(end): mass P, mean -h, variance 1 - end h - h². Below -6 the asymptotic expansion is
// used against cancellation: h = -end - 1/end + 2/end³ and variance 1/end² - 6/end⁴.
inline TruncatedNormal normal_below(double end) {
  const double mass = 0.5 * std::erfc(-end / std::numbers::sqrt2);
  if (end < -6.0) {
    return {mass, end + 1.0 / end - 2.0 / (end * end * end), (1.0 - 6.0 / (end * end)) / (end * end)};
  }
  const double h = std::exp(-0.5 * end * end) / std::sqrt(2.0 * std::numbers::pi) / mass;
  return {mass, -h, 1.0 - end * h - h * h};
}

}  // namespace livegs

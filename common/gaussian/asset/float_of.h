// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

namespace livegs {

// Converts to float; out of range becomes infinite (a plain cast would be undefined). NaN stays NaN.
inline float float_of(double value) {
  constexpr double kMax = std::numeric_limits<float>::max();
  if (value > kMax) return std::numeric_limits<float>::infinity();
  if (value < -kMax) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(value);
}

}  // namespace livegs

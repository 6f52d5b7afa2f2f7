// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace livegs {

// Replaces the infinite logit of an opacity of exactly 1 (negated: of 0): e^-16 is less than one float
// rounding step at 1.
inline constexpr float kMaxOpacityLogit = 16.0f;

inline float opacity_of_logit(float logit) { return 1.0f / (1.0f + std::exp(-logit)); }

// Logit of an eight-bit opacity, as most formats store it.
inline float logit_of_opacity_byte(unsigned byte) {
  if (byte == 0) return -kMaxOpacityLogit;
  if (byte >= 255) return kMaxOpacityLogit;
  return std::log(static_cast<float>(byte) / static_cast<float>(255 - byte));
}

}  // namespace livegs

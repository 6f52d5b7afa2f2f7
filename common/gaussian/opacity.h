// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace livegs {

// Stands for an opacity of exactly 1 (or, negated, 0), whose logit is infinite: e^-16 is less than one
// rounding step of a float at 1.
inline constexpr float kMaxOpacityLogit = 16.0f;

inline float opacity_of_logit(float logit) { return 1.0f / (1.0f + std::exp(-logit)); }

// The inverse, for the eight-bit opacities most formats store.
inline float logit_of_opacity_byte(unsigned byte) {
  if (byte == 0) return -kMaxOpacityLogit;
  if (byte >= 255) return kMaxOpacityLogit;
  return std::log(static_cast<float>(byte) / static_cast<float>(255 - byte));
}

}  // namespace livegs

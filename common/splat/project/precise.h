// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

// CPU functions of precise.glsl, which explains the steps.

namespace livegs {

inline float product_error(float a, float b, float product) {
  const float wide_a = 4097.0f * a;
  const float high_a = wide_a - (wide_a - a);
  const float low_a = a - high_a;
  const float wide_b = 4097.0f * b;
  const float high_b = wide_b - (wide_b - b);
  const float low_b = b - high_b;
  return ((high_a * high_b - product) + high_a * low_b + low_a * high_b) + low_a * low_b;
}

// a b - c d without cancellation. |a|, |b|, |c| and |d| under 1e34.
inline float product_difference(float a, float b, float c, float d) {
  const float first = a * b;
  const float second = c * d;
  return (first - second) + (product_error(a, b, first) - product_error(c, d, second));
}

// x must be positive, finite and normal.
inline float log2_of(float x) {
  const auto bits = std::bit_cast<uint32_t>(x);
  int exponent = static_cast<int>(bits >> 23) - 127;
  auto m = std::bit_cast<float>((bits & 0x007fffffu) | 0x3f800000u);
  if (m > 1.41421356f) {
    m *= 0.5f;
    exponent += 1;
  }
  const float s = (m - 1.0f) / (m + 1.0f);
  const float ss = s * s;
  const float series = 1.0f + ss * (0.333333333f + ss * (0.2f + ss * (0.142857143f + ss * 0.111111111f)));
  return static_cast<float>(exponent) + 2.88539008f * s * series;
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "splat/half_float.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace livegs {
namespace {

// Each half converts to a float and back.
TEST(HalfFloat, EveryHalfRoundTrips) {
  for (uint32_t bits = 0; bits < 0x10000u; ++bits) {
    const auto half = static_cast<uint16_t>(bits);
    const float value = float_of_half(half);
    if ((bits & 0x7fffu) > 0x7c00u) {
      EXPECT_TRUE(std::isnan(value));
      EXPECT_TRUE(std::isnan(float_of_half(half_of_float(value))));
    } else {
      ASSERT_EQ(half_of_float(value), half) << bits;
    }
  }
  EXPECT_EQ(float_of_half(0x3c00), 1.0f);
  EXPECT_EQ(float_of_half(0xc000), -2.0f);
  EXPECT_EQ(float_of_half(0x7bff), 65504.0f);
  EXPECT_EQ(float_of_half(0x0001), 0x1p-24f);
}

// Rounds to the nearer neighbour; at the midpoint, to the even one.
TEST(HalfFloat, RoundsToTheNearest) {
  for (uint32_t bits = 0; bits < 0x7bffu; ++bits) {
    const float low = float_of_half(static_cast<uint16_t>(bits));
    const float high = float_of_half(static_cast<uint16_t>(bits + 1));
    const float middle = 0.5f * (low + high);  // exact: a float has 13 more bits
    ASSERT_EQ(half_of_float(std::nextafter(middle, 0.0f)), bits);
    ASSERT_EQ(half_of_float(std::nextafter(middle, high)), bits + 1);
    ASSERT_EQ(half_of_float(middle), bits % 2 == 0 ? bits : bits + 1);
    ASSERT_EQ(half_of_float(-middle), 0x8000u | half_of_float(middle));
  }
  EXPECT_EQ(half_of_float(65519.0f), 0x7bff);
  EXPECT_EQ(half_of_float(65520.0f), 0x7c00);
  EXPECT_EQ(half_of_float(std::numeric_limits<float>::infinity()), 0x7c00);
}

}  // namespace
}  // namespace livegs

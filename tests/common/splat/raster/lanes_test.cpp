// SPDX-License-Identifier: Apache-2.0
#include "splat/raster/lanes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace livegs {
namespace {

TEST(Lanes, Exp2IsWithinItsErrorBound) {
  double worst = 0.0;
  for (int i = -125'999; i <= 125'999; i += 8) {
    const Lanes x = lanes(static_cast<float>(i) * 1e-3f) + 1e-3f * lane_indices();
    const Lanes y = exp2(x);
    for (int k = 0; k < 8 && i + k <= 125'999; ++k) {
      const double expected = std::exp2(static_cast<double>(x[k]));
      worst = std::max(worst, std::abs(y[k] - expected) / expected);
    }
  }
  EXPECT_LT(worst, 4e-7);
}

TEST(Lanes, MaskBitsAreInLaneOrder) {
  EXPECT_EQ(mask_bits(lane_indices() < 3.0f), 0b00000111u);
  EXPECT_EQ(mask_bits(lane_indices() == 6.0f), 0b01000000u);
}

}  // namespace
}  // namespace livegs

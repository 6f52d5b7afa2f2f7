// SPDX-License-Identifier: Apache-2.0
#include "splat/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace livegs {
namespace {

Image plain(int width, int height, float value) {
  return {width, height, std::vector<float>(4 * static_cast<size_t>(width) * height, value)};
}

TEST(Psnr, IsInfiniteForEqualImages) {
  EXPECT_EQ(psnr_db(plain(3, 2, 0.3f), plain(3, 2, 0.3f)), std::numeric_limits<double>::infinity());
}

TEST(Psnr, IsTheLogarithmOfAConstantError) {
  EXPECT_NEAR(psnr_db(plain(3, 2, 0.5f), plain(3, 2, 0.6f)), 20.0, 1e-5);  // float rounding of 0.1
}

TEST(Psnr, IsZeroForDifferentSizes) { EXPECT_EQ(psnr_db(plain(3, 2, 0.5f), plain(2, 3, 0.5f)), 0.0); }

TEST(Psnr, IgnoresAlpha) {
  Image other = plain(3, 2, 0.5f);
  other.pixels[3] = 1.0f;
  EXPECT_EQ(psnr_db(plain(3, 2, 0.5f), other), std::numeric_limits<double>::infinity());
}

TEST(RgbBytes, RoundToNearestAndStayInRange) {
  Image image = plain(2, 1, 0.0f);
  image.pixels = {-1.0f, 0.5f, 2.0f, 1.0f, 10.4f / 255.0f, 10.6f / 255.0f, std::nanf(""), 0.0f};
  EXPECT_EQ(rgb_bytes(image), (std::vector<uint8_t>{0, 128, 255, 10, 11, 0}));
}

}  // namespace
}  // namespace livegs

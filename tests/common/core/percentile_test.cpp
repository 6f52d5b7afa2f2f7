// SPDX-License-Identifier: Apache-2.0
#include "core/percentile.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

TEST(Percentile, IsTheNearestRankValue) {
  EXPECT_EQ(percentile(std::vector<double>{}, 0.5), 0.0);
  EXPECT_EQ(percentile(std::vector<double>{3}, 0.99), 3.0);
  const std::vector<double> five = {5, 1, 4, 2, 3};
  EXPECT_EQ(percentile(five, 0.0), 1.0);
  EXPECT_EQ(percentile(five, 0.5), 3.0);
  EXPECT_EQ(percentile(five, 0.8), 4.0);
  EXPECT_EQ(percentile(five, 0.99), 5.0);
  EXPECT_EQ(percentile(five, 1.0), 5.0);
}

TEST(Percentile, SelectsTheUpperMiddleNumber) { EXPECT_EQ(percentile(std::vector<int>{4, 1, 3, 2}, 0.5), 3); }

TEST(Percentile, MedianIsTheMeanOfTwoMiddleNumbers) {
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(median({4, 1, 3}), 3.0);
}

}  // namespace
}  // namespace livegs

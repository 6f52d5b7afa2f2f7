// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "session/support/duration_histogram.h"

namespace livegs {
namespace {

TEST(DurationHistogram, PercentilesAreWithinABin) {
  DurationHistogram histogram;
  for (int i = 1; i <= 1000; ++i) histogram.add(0.01 * i);
  // Bins are 2 % wide and the result is the middle, so 1 %; one rank in a thousand adds 0.1 % to 0.2 %.
  EXPECT_NEAR(histogram.percentile(0.50), 5.0, 5.0 * 0.012);
  EXPECT_NEAR(histogram.percentile(0.99), 9.9, 9.9 * 0.012);
  EXPECT_EQ(histogram.largest(), 10.0);
  EXPECT_EQ(histogram.count(), 1000u);
}

TEST(DurationHistogram, AcceptsAnyNumber) {
  DurationHistogram histogram;
  EXPECT_EQ(histogram.percentile(0.5), 0.0);
  for (double value : {0.0, 1e-30, 1e30, -1.0, std::nan("")}) histogram.add(value);
  EXPECT_EQ(histogram.count(), 3u);  // without the negative value and NaN
  EXPECT_LE(histogram.percentile(0.99), 1e30);
}

}  // namespace
}  // namespace livegs

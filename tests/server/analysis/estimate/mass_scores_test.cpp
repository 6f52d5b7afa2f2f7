// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/estimate/mass_scores.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace livegs {
namespace {

TEST(MassScores, MatchTheFormulas) {
  // Estimates of twice, half and the exact mass; the range of the first misses the truth.
  const std::vector<MassAnswer> answers = {
      {"a", 1.0, 1.5, 2.0, 3.0}, {"b", 2.0, 0.5, 1.0, 4.0}, {"c", 0.5, 0.4, 0.5, 0.6}};
  const MassScores scores = mass_scores(answers);
  EXPECT_DOUBLE_EQ(scores.mape.value, 0.5);
  EXPECT_DOUBLE_EQ(scores.median_ape.value, 0.5);
  EXPECT_DOUBLE_EQ(scores.max_ape.value, 1.0);
  EXPECT_DOUBLE_EQ(scores.ade_kg.value, 2.0 / 3);
  EXPECT_DOUBLE_EQ(scores.alde.value, 2 * std::log(2.0) / 3);
  EXPECT_DOUBLE_EQ(scores.mnre.value, 2.0 / 3);
  EXPECT_DOUBLE_EQ(scores.within_25.value, 1.0 / 3);
  EXPECT_DOUBLE_EQ(scores.within_2x.value, 1.0);
  EXPECT_DOUBLE_EQ(scores.coverage.value, 2.0 / 3);
  EXPECT_DOUBLE_EQ(scores.width.value, 2.0);
  // The first range, a factor of 4 / 3 downwards, would need a factor of 2.
  EXPECT_DOUBLE_EQ(scores.width_needed.value, std::pow(2.0, std::log(2.0) / std::log(4.0 / 3)));
}

// The standard error of a mean over n values of deviation s is s / sqrt(n); the 95 % interval is 1.96 times
// that.
TEST(MassScores, BootstrapIntervalIsThatOfAMean) {
  std::vector<MassAnswer> answers;
  for (int i = 0; i < 100; ++i) answers.push_back({"x", 1.0, 0.5, i % 2 ? 1.1 : 1.3, 2.0});
  const Figure mape = mass_scores(answers).mape;
  EXPECT_NEAR(mape.value, 0.2, 1e-12);
  EXPECT_NEAR(mape.high - mape.value, 1.96 * 0.1 / 10,
              0.003);  // 2000 resamplings determine a quantile to a tenth
  EXPECT_NEAR(mape.value - mape.low, 1.96 * 0.1 / 10, 0.003);
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "analysis/estimate/log_normal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace livegs {
namespace {

// With a wrong share of a few percent, agreeing estimates are hardly wider than least squares.
TEST(LogNormal, IndependentEstimatesAreWeightedByPrecision) {
  const LogNormal fused = fused_mixture({1.0, 0.1}, {1.1, 0.2}, 0.0)[0].value;
  EXPECT_NEAR(fused.mean_ln, (1.0 * 100 + 1.1 * 25) / 125, 1e-12);
  EXPECT_NEAR(fused.sd, std::sqrt(1.0 / 125), 1e-12);
  EXPECT_NEAR(fuse({1.0, 0.1}, {1.1, 0.2}, 0.0).sd, fused.sd, 0.02 * fused.sd);
}

// The variance of the best weighted mean of two correlated estimates of equal precision is (1 + rho) / 2 of
// one.
TEST(LogNormal, CorrelatedEstimatesCountAsFewer) {
  for (const double correlation : {0.0, 0.3, 0.9})
    EXPECT_NEAR(fused_mixture({1.0, 0.2}, {1.0, 0.2}, correlation)[0].value.sd,
                0.2 * std::sqrt(0.5 * (1 + correlation)), 1e-12);
}

// An estimate whose error is mostly that of the better one adds nothing.
TEST(LogNormal, FarLessCertainEstimateHasNoWeight) {
  const LogNormal fused = fused_mixture({1.0, 0.1}, {2.0, 1.0}, 0.3)[0].value;
  EXPECT_EQ(fused.mean_ln, 1.0);
  EXPECT_NEAR(fused.sd, 0.1, 1e-12);
}

TEST(LogNormal, ContradictingEstimatesWidenTheResult) {
  const LogNormal fused = fuse({0.0, 0.1}, {3.0, 0.1}, 0.0);
  EXPECT_NEAR(fused.mean_ln, 1.5, 1e-9);
  EXPECT_GT(fused.sd, 1.4);
  EXPECT_LT(fused.sd, 1.6);
}

// Ranges of 90 % of generated pairs, also if the assumed correlation is wrong, and if some are about
// something else.
TEST(LogNormal, RangesHoldNineInTen) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (const double correlation : {0.0, 0.3}) {
    for (const double wrong_share : {0.0, 0.02}) {
      size_t count = 0, held = 0;
      for (int i = 0; i < 40'000; ++i) {
        const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
        const double first_sd = 0.1 + 0.3 * draw(), second_sd = 0.1 + 0.5 * draw();
        const double one = normal(random),
                     other = correlation * one + std::sqrt(1 - correlation * correlation) * normal(random);
        const auto error = [&](double sd, double z) {
          return sd * z + (draw() < wrong_share ? 1.5 * normal(random) : 0.0);
        };
        const double first_error = error(first_sd, one), second_error = error(second_sd, other);
        const auto mixture = fused_mixture({first_error, first_sd}, {second_error, second_sd}, 0.3);
        ++count;
        held += mixture_quantile_ln(mixture, 0.05) <= 0 && mixture_quantile_ln(mixture, 0.95) >= 0;
      }
      const double share = 1.0 * held / count;
      EXPECT_GE(share, 0.88) << correlation << ' ' << wrong_share;
      EXPECT_LE(share, 0.95) << correlation << ' ' << wrong_share;
    }
  }
}

TEST(LogNormal, MixtureQuantilesMatchTheComponents) {
  const WeightedLogNormal one[] = {{2.0, {0.5, 0.3}}};
  EXPECT_NEAR(mixture_quantile_ln(one, 0.95), 0.5 + 1.6448536 * 0.3, 1e-6);
  EXPECT_NEAR(mixture_quantile_ln(one, 0.5), 0.5, 1e-9);
  // Well-separated components: the lower third of the weight is the first component.
  const WeightedLogNormal two[] = {{1.0, {-10.0, 0.1}}, {2.0, {10.0, 0.1}}};
  EXPECT_NEAR(mixture_quantile_ln(two, 1.0 / 6), -10.0, 1e-6);
  EXPECT_NEAR(mixture_quantile_ln(two, 2.0 / 3), 10.0, 1e-6);
  EXPECT_NEAR(mixture_mean_ln(two), 10.0 / 3, 1e-12);
}

}  // namespace
}  // namespace livegs

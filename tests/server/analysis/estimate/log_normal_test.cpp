// SPDX-License-Identifier: Apache-2.0
#include "analysis/estimate/log_normal.h"

#include <gtest/gtest.h>

#include <cmath>

namespace livegs {
namespace {

TEST(LogNormal, IndependentEstimatesAreWeightedByPrecision) {
  const LogNormal estimates[] = {{1.0, 0.1}, {1.1, 0.2}};
  const LogNormal fused = fuse(estimates, 0.0);
  EXPECT_NEAR(fused.mean_ln, (1.0 * 100 + 1.1 * 25) / 125, 1e-12);
  EXPECT_NEAR(fused.sd, std::sqrt(1.0 / 125), 1e-12);
}

TEST(LogNormal, FullyCorrelatedEstimatesCountAsOne) {
  const LogNormal estimates[] = {{1.0, 0.2}, {1.0, 0.2}};
  EXPECT_NEAR(fuse(estimates, 1.0).sd, 0.2, 1e-12);
}

TEST(LogNormal, ContradictingEstimatesWidenTheResult) {
  const LogNormal estimates[] = {{0.0, 0.1}, {1.0, 0.1}};
  EXPECT_NEAR(fuse(estimates, 0.0).sd, 0.5, 1e-12);  // Birge: sqrt(chi2) = sqrt(50), times 0.1 / sqrt(2)
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

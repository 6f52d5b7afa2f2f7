// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset_summary.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/gaussian/synthetic_asset.h"

namespace livegs {
namespace {

TEST(AssetSummary, PercentilesAreExistingValues) {
  GaussianAsset asset = synthetic_asset(100, 1, 1);
  double sum = 0;
  for (size_t i = 0; i < 100; ++i) {
    const size_t rank = i * 37 % 100 + 1;  // 1 to 100 in another order
    const double opacity = static_cast<double>(rank) / 101;
    sum += opacity;
    asset.opacity_logits[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
    const float scale = std::log(static_cast<float>(rank));
    asset.log_scales[i] = {scale - 1, scale, scale + 1};  // with a geometric mean equal to the rank
  }
  asset.positions[50] = {-9, 0, 9};
  const AssetSummary summary = summarise(asset);
  EXPECT_EQ(summary.count, 100u);
  EXPECT_EQ(summary.sh_degree, 1);
  EXPECT_EQ(summary.bounds_min.x(), -9);
  EXPECT_EQ(summary.bounds_max.z(), 9);
  // Float rounding of exp and log.
  EXPECT_NEAR(summary.opacity.p1, 1.0 / 101, 1e-6);
  EXPECT_NEAR(summary.opacity.p50, 50.0 / 101, 1e-6);
  EXPECT_NEAR(summary.opacity.p99, 99.0 / 101, 1e-6);
  EXPECT_NEAR(summary.mean_opacity, sum / 100, 1e-6);
  EXPECT_NEAR(summary.scale.p1, 1, 1e-5);
  EXPECT_NEAR(summary.scale.p50, 50, 5e-5);
  EXPECT_NEAR(summary.scale.p99, 99, 1e-4);
}

TEST(AssetSummary, OneKernelGivesAllPercentiles) {
  const AssetSummary summary = summarise(synthetic_asset(1, 0, 2));
  EXPECT_EQ(summary.opacity.p1, summary.opacity.p99);
  EXPECT_EQ(summary.bounds_min, summary.bounds_max);
}

TEST(AssetSummary, IsZeroForAnEmptyAsset) { EXPECT_EQ(summarise(GaussianAsset{}).count, 0u); }

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "analysis/estimate.h"

namespace livegs {
namespace {

GaussianAsset painted(const std::vector<Eigen::Vector3f>& colours, float logit) {
  GaussianAsset asset;
  asset.resize(colours.size());
  for (size_t i = 0; i < colours.size(); ++i) {
    asset.positions[i].setZero();
    asset.log_scales[i].setConstant(-3.0f);
    asset.rotations[i].setIdentity();
    asset.opacity_logits[i] = logit;
    asset.sh_dc[i] = (colours[i].array() - 0.5f).matrix() / 0.28209479f;
  }
  return asset;
}

TEST(AppearanceFacts, AveragesKernelColours) {
  const AppearanceFacts facts = appearance_facts(painted({{1, 0, 0}, {0.5f, 0.5f, 0.5f}}, 0.0f));
  EXPECT_NEAR((facts.mean_rgb - Eigen::Vector3f(0.75f, 0.25f, 0.25f)).norm(), 0, 1e-6);
  EXPECT_NEAR(facts.mean_opacity, 0.5, 1e-6);
  EXPECT_NEAR(facts.saturation, 0.5, 1e-6);  // mean of one full and one zero
  EXPECT_NEAR(facts.hue_spread, 0.0, 1e-3);  // only one hue
  EXPECT_EQ(facts.gloss, 0.0f);
}

TEST(AppearanceFacts, OppositeHuesHaveMaximumSpread) {
  EXPECT_GT(appearance_facts(painted({{1, 0, 0}, {0, 1, 1}}, 2.0f)).hue_spread, 2.0f);
}

TEST(AppearanceFacts, EmptyAssetHasNoFacts) { EXPECT_EQ(appearance_facts({}).mean_opacity, 0.0f); }

}  // namespace
}  // namespace livegs

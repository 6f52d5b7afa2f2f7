// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/render_scale.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

constexpr double kBudget_ms = 20;

// The threshold in pixels of the window.
double threshold_px(const RenderScale& scale) {
  return scale.min_contribution_px() / (scale.value() * scale.value());
}

// A renderer with a known cost per kernel and per pixel; each pixel of threshold halves the number of
// kernels.
struct Drawer {
  double kernels_ms = 0, pixels_ms = 0;  // at full size, with all kernels
  double ms(const RenderScale& scale) const {
    return kernels_ms * std::exp2(-threshold_px(scale)) + pixels_ms * scale.value() * scale.value();
  }
  // Draws `pictures`; returns the time of the last, and whether the size changed in the last ten.
  double draw(RenderScale& scale, int pictures, bool* changed = nullptr) const {
    double last_ms = 0;
    if (changed) *changed = false;
    for (int i = 0; i < pictures; ++i) {
      const double before = scale.value();
      last_ms = ms(scale);
      scale.drew(last_ms);
      if (changed && i >= pictures - 10 && scale.value() != before) *changed = true;
    }
    return last_ms;
  }
};

TEST(RenderScale, UnlimitedBudgetKeepsFullSize) {
  RenderScale scale(kUnlimitedBudget_ms);
  Drawer{5000, 5000}.draw(scale, 100);
  EXPECT_EQ(scale.value(), 1.0);
  EXPECT_EQ(scale.min_contribution_px(), 0.0f);
}

TEST(RenderScale, KeepsFullSizeWhileOnTime) {
  RenderScale scale(kBudget_ms);
  Drawer{5, 14}.draw(scale, 100);
  EXPECT_EQ(scale.value(), 1.0);
  EXPECT_EQ(scale.min_contribution_px(), 0.0f);
}

TEST(RenderScale, ReducesSizeAndKernelsUntilOnTime) {
  RenderScale scale(kBudget_ms);
  const Drawer close{5, 60};  // close to an object
  bool changed = true;
  EXPECT_LT(close.draw(scale, 40, &changed), kBudget_ms);
  EXPECT_FALSE(changed);
  EXPECT_LT(scale.value(), 0.75);
  EXPECT_GT(threshold_px(scale), 0.3);
  // And back: no kernels are culled.
  Drawer{5, 8}.draw(scale, 40, &changed);
  EXPECT_FALSE(changed);
  EXPECT_EQ(scale.value(), 1.0);
  EXPECT_EQ(scale.min_contribution_px(), 0.0f);
}

// At most four late pictures after a sudden step into an object: each may shrink to seven tenths, 0.7^4 =
// 0.24.
TEST(RenderScale, FourfoldCostIsCorrectedInFourPictures) {
  RenderScale scale(kBudget_ms);
  const Drawer inside{0, 4 * kBudget_ms};
  EXPECT_LT(inside.draw(scale, 5), kBudget_ms);
}

// Sizes do not alternate at any cost up to sixteen times the budget.
TEST(RenderScale, SizesDoNotOscillate) {
  for (double share = 0.5; share < 15.9; share *= 1.013) {
    RenderScale scale(kBudget_ms);
    bool changed = true;
    const Drawer drawer{0, share * kBudget_ms};
    EXPECT_LE(drawer.draw(scale, 60, &changed), kBudget_ms) << share;
    EXPECT_FALSE(changed) << share;
  }
}

// At the minimum size, culling helps a little further.
TEST(RenderScale, CullsKernelsAtMinimumSize) {
  RenderScale scale(kBudget_ms);
  const Drawer many{200, 10};
  EXPECT_LT(many.draw(scale, 40), kBudget_ms);
  EXPECT_EQ(scale.value(), 0.25);
  EXPECT_GT(threshold_px(scale), 3.0);
}

// A picture that stays late does not become empty: the threshold is at most four pixels of the window.
TEST(RenderScale, ThresholdIsBounded) {
  RenderScale scale(kBudget_ms);
  for (int i = 0; i < 100; ++i) scale.drew(1e6);
  EXPECT_EQ(scale.value(), 0.25);
  EXPECT_NEAR(threshold_px(scale), 4.0, 1e-6);
  for (int i = 0; i < 100; ++i) scale.drew(0);
  EXPECT_EQ(scale.value(), 1.0);
  EXPECT_EQ(scale.min_contribution_px(), 0.0f);
}

TEST(RenderScale, WindowBudgetFollowsMonitor) {
  EXPECT_DOUBLE_EQ(window_budget_ms(60), 30.0);
  EXPECT_DOUBLE_EQ(window_budget_ms(144), 12.5);
  EXPECT_DOUBLE_EQ(window_budget_ms(0), window_budget_ms(60));  // a display with an unknown rate
  EXPECT_DOUBLE_EQ(window_budget_ms(24), 40.0);
  EXPECT_DOUBLE_EQ(window_budget_ms(500), 8.0);
}

}  // namespace
}  // namespace livegs

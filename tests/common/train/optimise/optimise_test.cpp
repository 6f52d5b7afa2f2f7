// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "train/optimise/adam.h"
#include "train/optimise/densify.h"
#include "train/optimise/random_number.h"

namespace livegs {
namespace {

KernelParameters like_kernels(size_t count) {
  KernelParameters kernels;
  kernels.resize(count);
  for (size_t k = 0; k < count; ++k) kernels.row(Family::Rotation, k)[0] = 1;
  return kernels;
}

}  // namespace

// Gradients of a mean over 76800 pixels are about 1e-9. With the usual epsilon of 1e-8 the numbers would move
// by a tenth of the rate.
TEST(Adam, TinyGradientsMoveByTheRate) {
  KernelParameters kernels = like_kernels(1), gradient = like_kernels(1);
  gradient.row(Family::Position, 0)[0] = 1e-9f;
  AdamState adam;
  adam.resize(1);
  Rates rates{};
  rates[0] = 0.01;
  const uint8_t visible = 1;
  adam_step(gradient, rates, std::span(&visible, 1), adam, kernels);
  EXPECT_NEAR(kernels.row(Family::Position, 0)[0], -0.01f, 1e-5f);
}

TEST(Adam, HarmonicsOfUnseenKernelsKeepTheirMoments) {
  KernelParameters kernels = like_kernels(2), gradient = like_kernels(2);
  gradient.row(Family::Harmonics, 0)[3] = gradient.row(Family::Harmonics, 1)[3] = 1;
  AdamState adam;
  adam.resize(2);
  Rates rates{};
  rates[5] = 0.5;
  const uint8_t visible[2] = {1, 0};
  adam_step(gradient, rates, visible, adam, kernels);
  EXPECT_NEAR(kernels.row(Family::Harmonics, 0)[3], -0.5f, 1e-5f);
  EXPECT_EQ(kernels.row(Family::Harmonics, 1)[3], 0.0f);
  EXPECT_EQ(adam.second.row(Family::Harmonics, 1)[3], 0.0f);
}

// N copies in one place cover as much as the kernel: 1 - (1 - a')^N = a; one copy is the kernel itself.
TEST(Densify, CopiesCoverAsMuchAsTheKernel) {
  EXPECT_NEAR(copied_kernel(0.7, 1).opacity, 0.7, 1e-12);
  EXPECT_NEAR(copied_kernel(0.7, 1).scale_factor, 1.0, 1e-12);
  for (int copies : {2, 5, 20}) {
    const CopiedKernel copied = copied_kernel(0.7, copies);
    EXPECT_NEAR(1 - std::pow(1 - copied.opacity, copies), 0.7, 1e-12);
    EXPECT_LT(copied.scale_factor, 1.0);
    EXPECT_GT(copied.scale_factor, 0.5);
  }
}

// The copies leave the integral of the blended ray unchanged, which is how equation 9 is derived: the sum of
// the terms of the blend along the axis equals a sqrt(2 pi) s.
TEST(Densify, CopiesKeepTheOpacityAlongALine) {
  const double opacity = 0.6;
  const int copies = 3;
  const CopiedKernel copied = copied_kernel(opacity, copies);
  const double scale = copied.scale_factor;
  double before = 0, after = 0;
  for (double x = -8; x <= 8; x += 0.001) {
    before += opacity * std::exp(-0.5 * x * x);
    const double one = copied.opacity * std::exp(-0.5 * x * x / (scale * scale));
    after += 1 - std::pow(1 - one, copies);
  }
  EXPECT_NEAR(after / before, 1.0, 1e-3);
}

TEST(Densify, DeadAndNotFiniteKernelsAreMoved) {
  KernelParameters kernels = like_kernels(6);
  for (size_t k = 0; k < 6; ++k) kernels.row(Family::Position, k)[0] = static_cast<float>(k);
  *kernels.row(Family::Opacity, 1) = -9.0f;  // transparent
  kernels.row(Family::Position, 2)[1] = std::numeric_limits<float>::quiet_NaN();
  kernels.row(Family::Rotation, 3)[0] = 0.0f;  // no direction
  kernels.row(Family::Harmonics, 4)[7] = std::numeric_limits<float>::infinity();
  AdamState adam;
  adam.resize(6);
  for (auto& family : adam.first.families) std::fill(family.begin(), family.end(), 1.0f);
  EXPECT_EQ(relocate_dead(1, 10, kernels, adam), 4u);
  for (size_t k = 1; k <= 4; ++k) {
    const float place = kernels.row(Family::Position, k)[0];
    EXPECT_TRUE(place == 0.0f || place == 5.0f) << place;
    EXPECT_EQ(kernels.row(Family::Position, k)[1], 0.0f);
    EXPECT_EQ(adam.first.row(Family::Position, k)[0], 0.0f);
  }
  for (const auto& family : kernels.families) {
    for (float number : family) EXPECT_TRUE(std::isfinite(number));
  }
}

TEST(Densify, GrowthStopsAtTheCap) {
  KernelParameters kernels = like_kernels(100);
  AdamState adam;
  adam.resize(100);
  EXPECT_EQ(grow(1, 10, 1000, kernels, adam), 5u);
  EXPECT_EQ(kernels.size(), 105u);
  EXPECT_EQ(adam.first.size(), 105u);
  EXPECT_EQ(grow(1, 20, 107, kernels, adam), 2u);
  EXPECT_EQ(grow(1, 30, 107, kernels, adam), 0u);
}

TEST(Densify, NoiseMovesTransparentKernelsAlongTheirAxes) {
  KernelParameters kernels = like_kernels(2000);
  for (size_t k = 0; k < 2000; ++k) {
    kernels.row(Family::LogScale, k)[0] = -1.0f;
    kernels.row(Family::LogScale, k)[1] = kernels.row(Family::LogScale, k)[2] = -20.0f;
    *kernels.row(Family::Opacity, k) = k < 1000 ? -12.0f : 2.0f;
  }
  constexpr double kRate = 1e-6;
  add_noise(5, 3, kRate, kernels);
  double sum = 0, squares = 0;
  for (size_t k = 0; k < 1000; ++k) {
    const double x = kernels.row(Family::Position, k)[0];
    sum += x;
    squares += x * x;
    EXPECT_NEAR(kernels.row(Family::Position, k)[1], 0.0f, 1e-6f);
    EXPECT_EQ(kernels.row(Family::Position, 1000 + k)[0], 0.0f);
  }
  // Variance e^-2 times the strength 5e5 rate / (1 + e^(100 (a - 0.005))); 1000 samples give 5 %.
  const double strength = 5e5 * kRate / (1 + std::exp(100 * (1 / (1 + std::exp(12.0)) - 0.005)));
  EXPECT_NEAR(std::sqrt(squares / 1000), strength * std::exp(-2.0), 0.1 * strength * std::exp(-2.0));
  EXPECT_NEAR(sum / 1000, 0, 0.15 * strength * std::exp(-2.0));
}

TEST(RandomNumber, SharesAreUniformAndDoNotDependOnOrder) {
  double sum = 0;
  for (uint64_t i = 0; i < 10000; ++i) sum += random_share(1, 2, i);
  EXPECT_NEAR(sum / 10000, 0.5, 0.01);  // three deviations are 0.009
  EXPECT_EQ(random_share(1, 2, 77), random_share(1, 2, 77));
  EXPECT_NE(random_share(1, 2, 77), random_share(1, 3, 77));
}

}  // namespace livegs

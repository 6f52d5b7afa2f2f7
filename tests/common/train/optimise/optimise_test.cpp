// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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

// A turned kernel: the mixture of the halves has its mean and its covariance, and each half its opacity.
TEST(Densify, HalvesKeepTheMeanTheCovarianceAndTheOpacity) {
  KernelParameters kernels = like_kernels(1);
  const Eigen::Quaternionf turn = Eigen::Quaternionf(0.8f, 0.3f, -0.4f, 0.2f).normalized();
  const float q[4] = {turn.w(), turn.x(), turn.y(), turn.z()};
  std::copy_n(q, 4, kernels.row(Family::Rotation, 0));
  const Eigen::Vector3f centre(1, 2, 3);
  for (int i = 0; i < 3; ++i) {
    kernels.row(Family::Position, 0)[i] = centre[i];
    kernels.row(Family::LogScale, 0)[i] = std::log(0.1f * static_cast<float>(1 + (i + 1) % 3));
  }
  const double opacity = 0.5;
  *kernels.row(Family::Opacity, 0) = static_cast<float>(std::log(opacity / (1 - opacity)));
  const auto covariance = [&](size_t k) {
    Eigen::Vector3f variance;
    for (int i = 0; i < 3; ++i) variance[i] = std::exp(2 * kernels.row(Family::LogScale, k)[i]);
    const Eigen::Matrix3f r = turn.toRotationMatrix();
    return Eigen::Matrix3f(r * variance.asDiagonal() * r.transpose());
  };
  const auto offset = [&](size_t k) {
    return Eigen::Vector3f(Eigen::Map<const Eigen::Vector3f>(kernels.row(Family::Position, k)) - centre);
  };
  const Eigen::Matrix3f before = covariance(0);
  AdamState adam;
  adam.resize(1);
  std::vector<float> errors = {4};
  ASSERT_EQ(grow(1, 10, 2, errors, kernels, adam), 1u);
  EXPECT_EQ(errors, (std::vector<float>{2, 2}));
  EXPECT_NEAR((offset(0) + offset(1)).norm(), 0, 1e-6);
  EXPECT_NEAR(offset(0).norm(), kSplitOffset * 0.3, 1e-6);
  const Eigen::Matrix3f after = covariance(0) + offset(0) * offset(0).transpose();
  EXPECT_NEAR((after - before).norm(), 0, 1e-6);
  for (size_t k : {0, 1})
    EXPECT_NEAR(1 / (1 + std::exp(-double{*kernels.row(Family::Opacity, k)})), opacity, 1e-6);
}

TEST(Densify, DeadAndNotFiniteKernelsAreMoved) {
  KernelParameters kernels = like_kernels(10);
  for (size_t k = 0; k < 10; ++k) kernels.row(Family::Position, k)[0] = 100 * static_cast<float>(k);
  *kernels.row(Family::Opacity, 1) = -9.0f;  // transparent
  kernels.row(Family::Position, 2)[1] = std::numeric_limits<float>::quiet_NaN();
  kernels.row(Family::Rotation, 3)[0] = 0.0f;  // no direction
  kernels.row(Family::Harmonics, 4)[7] = std::numeric_limits<float>::infinity();
  AdamState adam;
  adam.resize(10);
  for (auto& family : adam.first.families) std::fill(family.begin(), family.end(), 1.0f);
  std::vector<float> errors(10, 1.0f);
  errors[9] = 0;  // never drawn
  EXPECT_EQ(relocate_dead(1, 10, errors, kernels, adam), 4u);
  std::vector<int> halves(10, 0);
  for (size_t k = 0; k < 10; ++k) {
    const float place = kernels.row(Family::Position, k)[0] / 100;
    const auto source = static_cast<size_t>(std::lround(place));
    ASSERT_LT(source, 10u);
    EXPECT_NEAR(place, static_cast<float>(source), 0.01f);
    ++halves[source];
    EXPECT_EQ(kernels.row(Family::Position, k)[1], 0.0f);
    if (k >= 1 && k <= 4) EXPECT_EQ(adam.first.row(Family::Position, k)[0], 0.0f);
  }
  for (size_t k : {1, 2, 3, 4}) EXPECT_EQ(halves[k], 0);
  EXPECT_EQ(halves[9], 1);
  for (size_t k : {0, 5, 6, 7, 8}) EXPECT_LE(halves[k], 2);  // each is split once at most
  for (const auto& family : kernels.families) {
    for (float number : family) EXPECT_TRUE(std::isfinite(number));
  }
}

// Of two groups of equal size, the one with nine times the error gets nine tenths of the new kernels.
TEST(Densify, NewKernelsFollowTheError) {
  KernelParameters kernels = like_kernels(20'000);
  std::vector<float> errors(20'000, 1.0f);
  for (size_t k = 0; k < 10'000; ++k) {
    errors[k] = 9;
    kernels.row(Family::Position, k)[0] = 100;
  }
  AdamState adam;
  adam.resize(20'000);
  ASSERT_EQ(grow(3, 10, 30'000, errors, kernels, adam), 1000u);
  int first = 0;
  for (size_t k = 20'000; k < kernels.size(); ++k) first += kernels.row(Family::Position, k)[0] > 50 ? 1 : 0;
  EXPECT_NEAR(first, 900, 30);  // three standard deviations
}

TEST(Densify, GrowthStopsAtTheCap) {
  KernelParameters kernels = like_kernels(100);
  AdamState adam;
  adam.resize(100);
  std::vector<float> errors(100, 1.0f);
  EXPECT_EQ(grow(1, 10, 1000, errors, kernels, adam), 5u);
  EXPECT_EQ(kernels.size(), 105u);
  EXPECT_EQ(adam.first.size(), 105u);
  EXPECT_EQ(errors.size(), 105u);
  EXPECT_EQ(grow(1, 20, 107, errors, kernels, adam), 2u);
  EXPECT_EQ(grow(1, 30, 107, errors, kernels, adam), 0u);
  std::fill(errors.begin(), errors.end(), 0.0f);
  EXPECT_EQ(grow(1, 40, 1000, errors, kernels, adam), 0u);
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

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "train/loss/picture_loss.h"
#include "train/loss/shape_loss.h"
#include "train/optimise/random_number.h"

namespace livegs {
namespace {

constexpr int kWidth = 23, kHeight = 19;

PicturePlanes noisy_planes(uint64_t seed) {
  PicturePlanes planes;
  planes.resize(kWidth, kHeight);
  for (size_t i = 0; i < planes.pixels(); ++i) {
    planes.red[i] = static_cast<float>(random_share(seed, 1, i));
    planes.green[i] = static_cast<float>(random_share(seed, 2, i));
    planes.blue[i] = static_cast<float>(random_share(seed, 3, i));
    planes.alpha[i] = static_cast<float>(random_share(seed, 4, i));
  }
  return planes;
}

// The window as one sum over 11 x 11 pixels around (x, y), in double precision.
template <class Value>
double windowed(int x, int y, const Value& value) {
  double sum = 0, total = 0;
  for (int j = -5; j <= 5; ++j) {
    for (int i = -5; i <= 5; ++i) {
      const double weight = std::exp(-(i * i + j * j) / (2 * kSsimDeviation_px * kSsimDeviation_px));
      total += weight;
      if (x + i < 0 || x + i >= kWidth || y + j < 0 || y + j >= kHeight) continue;
      sum += weight * value(static_cast<size_t>((y + j) * kWidth + x + i));
    }
  }
  return sum / total;
}

double direct_ssim(const std::vector<double>& a, const std::vector<float>& b) {
  double sum = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double ma = windowed(x, y, [&](size_t i) { return a[i]; });
      const double mb = windowed(x, y, [&](size_t i) { return double{b[i]}; });
      const double va = windowed(x, y, [&](size_t i) { return a[i] * a[i]; }) - ma * ma;
      const double vb = windowed(x, y, [&](size_t i) { return double{b[i]} * b[i]; }) - mb * mb;
      const double ab = windowed(x, y, [&](size_t i) { return a[i] * b[i]; }) - ma * mb;
      sum += (2 * ma * mb + kSsimC1) * (2 * ab + kSsimC2) /
             ((ma * ma + mb * mb + kSsimC1) * (va + vb + kSsimC2));
    }
  }
  return sum / (kWidth * kHeight);
}

double direct_loss(const std::vector<double>& a, const std::vector<float>& b) {
  double difference = 0;
  for (size_t i = 0; i < a.size(); ++i) difference += std::abs(a[i] - double{b[i]});
  return (1 - double{kSsimWeight}) * difference / static_cast<double>(a.size()) +
         double{kSsimWeight} * (1 - direct_ssim(a, b));
}

std::vector<double> doubles(const std::vector<float>& plane) { return {plane.begin(), plane.end()}; }

}  // namespace

TEST(PictureLoss, SsimIsThatOfTheDirectSum) {
  const PicturePlanes a = noisy_planes(1), b = noisy_planes(2);
  const double expected = (direct_ssim(doubles(a.red), b.red) + direct_ssim(doubles(a.green), b.green) +
                           direct_ssim(doubles(a.blue), b.blue)) /
                          3;
  PictureLoss loss;
  EXPECT_NEAR(loss.ssim(a, b), expected, 1e-5);
  EXPECT_NEAR(loss.ssim(a, a), 1.0, 1e-5);
}

// A window that is not centred on its pixel weights the left of a picture unlike the right.
TEST(PictureLoss, WindowIsCentred) {
  PicturePlanes a = noisy_planes(1), b = noisy_planes(2), mirrored_a = a, mirrored_b = b;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto from = static_cast<size_t>(y * kWidth + x),
                 to = static_cast<size_t>(y * kWidth + kWidth - 1 - x);
      mirrored_a.red[to] = a.red[from];
      mirrored_b.red[to] = b.red[from];
    }
  }
  PictureLoss loss;
  PicturePlanes by, mirrored_by;
  loss.evaluate(a, b, {}, 0, by);
  loss.evaluate(mirrored_a, mirrored_b, {}, 0, mirrored_by);
  for (int x = 0; x < kWidth; ++x) {
    const auto at = static_cast<size_t>(9 * kWidth + x),
               mirror = static_cast<size_t>(9 * kWidth + kWidth - 1 - x);
    EXPECT_NEAR(by.red[at], mirrored_by.red[mirror], 1e-9);
  }
}

TEST(PictureLoss, GradientAgreesWithCentralDifferences) {
  const PicturePlanes a = noisy_planes(1), b = noisy_planes(2);
  PictureLoss loss;
  PicturePlanes by;
  const double value = loss.evaluate(a, b, {}, 0, by);
  EXPECT_NEAR(value,
              (direct_loss(doubles(a.red), b.red) + direct_loss(doubles(a.green), b.green) +
               direct_loss(doubles(a.blue), b.blue)) /
                  3,
              1e-5);
  std::vector<double> moved = doubles(a.green);
  double largest = 0;
  for (float one : by.green) largest = std::max(largest, std::abs(double{one}));
  for (size_t i = 0; i < moved.size(); i += 7) {
    const double kept = moved[i];
    constexpr double kStep = 1e-5;
    moved[i] = kept + kStep;
    const double above = direct_loss(moved, b.green);
    moved[i] = kept - kStep;
    const double below = direct_loss(moved, b.green);
    moved[i] = kept;
    EXPECT_NEAR(by.green[i], (above - below) / (2 * kStep) / 3, 1e-3 * largest) << i;
  }
}

TEST(PictureLoss, PixelsThatDoNotCountHaveNoGradient) {
  const PicturePlanes a = noisy_planes(1), b = noisy_planes(2);
  std::vector<uint8_t> counts(a.pixels(), 255);
  for (size_t i = 0; i < 100; ++i) counts[i] = 0;
  PictureLoss loss;
  PicturePlanes by;
  loss.evaluate(a, b, counts, 0.1f, by);
  for (size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(by.red[i], 0.0f);
    EXPECT_EQ(by.alpha[i], 0.0f);
  }
  EXPECT_NE(by.red[150], 0.0f);
}

TEST(ShapeLoss, GradientAgreesWithCentralDifferences) {
  for (ShapeLoss kind : {ShapeLoss::None, ShapeLoss::Needle, ShapeLoss::Anisotropy}) {
    ShapeOptions options;
    options.loss = kind;
    options.weight = 0.7f;
    KernelParameters kernels;
    kernels.resize(5);
    for (size_t i = 0; i < kernels.of(Family::LogScale).size(); ++i)
      kernels.of(Family::LogScale)[i] = static_cast<float>(3 * random_share(3, 1, i) - 2);
    for (size_t k = 0; k < 5; ++k) *kernels.row(Family::Opacity, k) = static_cast<float>(k) - 2.0f;
    KernelParameters gradient;
    gradient.resize(5);
    add_shape_loss(kernels, options, 2.0, gradient);
    for (Family family : {Family::LogScale, Family::Opacity}) {
      for (size_t i = 0; i < kernels.of(family).size(); ++i) {
        float& number = kernels.of(family)[i];
        const float kept = number;
        KernelParameters unused;
        unused.resize(5);
        // Rounding of the float terms, 1e-7, over twice the step is 2e-5 of the loss.
        constexpr float kStep = 1.0f / 256;
        number = kept + kStep;
        const double above = add_shape_loss(kernels, options, 2.0, unused);
        number = kept - kStep;
        const double below = add_shape_loss(kernels, options, 2.0, unused);
        number = kept;
        EXPECT_NEAR(gradient.of(family)[i], (above - below) / (2.0 * kStep),
                    2e-5 + 1e-3 * std::abs(gradient.of(family)[i]));
      }
    }
  }
}

TEST(ShapeLoss, NeedleLossAllowsDiscs) {
  KernelParameters kernels;
  kernels.resize(1);
  kernels.row(Family::LogScale, 0)[2] = -5.0f;  // a disc: two axes of 1
  ShapeOptions options;
  options.opacity_weight = options.scale_weight = 0;
  KernelParameters gradient;
  gradient.resize(1);
  EXPECT_EQ(add_shape_loss(kernels, options, 1.0, gradient), 0.0);
  options.loss = ShapeLoss::Anisotropy;
  EXPECT_NEAR(add_shape_loss(kernels, options, 1.0, gradient), std::exp(5.0) - 3, 1e-3);
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
// Wang et al. 2004, Image Quality Assessment, equation 13. The blur is its own adjoint, so the derivative by
// the picture is three more blurs.
#include "train/loss/picture_loss.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/parallel_for.h"
#include "splat/raster/lanes.h"

namespace livegs {
namespace {

constexpr int kReach = kSsimWindow / 2;
constexpr size_t kRowBlock = 16;

std::array<float, kSsimWindow> window() {
  std::array<double, kSsimWindow> weights{};
  double sum = 0;
  for (int i = 0; i < kSsimWindow; ++i) {
    const double d = (i - kReach) / kSsimDeviation_px;
    weights[static_cast<size_t>(i)] = std::exp(-0.5 * d * d);
    sum += weights[static_cast<size_t>(i)];
  }
  std::array<float, kSsimWindow> result{};
  for (size_t i = 0; i < kSsimWindow; ++i) result[i] = static_cast<float>(weights[i] / sum);
  return result;
}
const std::array<float, kSsimWindow> kWindow = window();

// out[x] = sum over i of weights[i] * in[x + i * stride], for `width` sums of `count` terms, eight at a time.
void weighted_sums(const float* in, ptrdiff_t stride, const float* weights, int count, int width,
                   float* out) {
  int x = 0;
  for (; x + 8 <= width; x += 8) {
    Lanes sum{}, value;
    for (int i = 0; i < count; ++i) {
      std::memcpy(&value, in + x + i * stride, sizeof value);
      sum += weights[i] * value;
    }
    std::memcpy(out + x, &sum, sizeof sum);
  }
  for (; x < width; ++x) {
    float sum = 0;
    for (int i = 0; i < count; ++i) sum += weights[i] * in[x + i * stride];
    out[x] = sum;
  }
}

// One row blurred. `padded` has kReach zeros at both ends.
void blur_row(const float* padded, int width, float* out) {
  weighted_sums(padded, 1, kWindow.data(), kSsimWindow, width, out);
}

// Blur down the columns at row y of a plane whose rows are blurred.
void blur_column(const float* plane, int width, int height, int y, float* out) {
  const int first = std::max(0, kReach - y), last = std::min(kSsimWindow, height - y + kReach);
  weighted_sums(plane + static_cast<ptrdiff_t>(y + first - kReach) * width, width, kWindow.data() + first,
                last - first, width, out);
}

template <class Planes>
std::array<decltype(Planes().red.data()), 3> colours_of(Planes& planes) {
  return {planes.red.data(), planes.green.data(), planes.blue.data()};
}

}  // namespace

double PictureLoss::plane_ssim(const float* x, const float* y, int width, int height, bool with_gradient,
                               float* by_x, float scale) {
  const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
  for (auto& plane : rows_) plane.resize(count);
  const size_t row_width = static_cast<size_t>(width);
  parallel_for(static_cast<size_t>(height), kRowBlock, [&](size_t begin, size_t end) {
    std::vector<float> padded(row_width + 2 * kReach, 0.0f);
    float* inner = padded.data() + kReach;
    for (size_t row = begin; row < end; ++row) {
      const float* px = x + row * row_width;
      const float* py = y + row * row_width;
      const auto blur = [&](int plane) {
        blur_row(padded.data(), width, rows_[plane].data() + row * row_width);
      };
      std::copy_n(px, width, inner);
      blur(0);
      std::copy_n(py, width, inner);
      blur(1);
      for (int i = 0; i < width; ++i) inner[i] = px[i] * px[i];
      blur(2);
      for (int i = 0; i < width; ++i) inner[i] = py[i] * py[i];
      blur(3);
      for (int i = 0; i < width; ++i) inner[i] = px[i] * py[i];
      blur(4);
    }
  });
  if (with_gradient) {
    for (auto& map : maps_) map.resize(count);
  }
  const size_t blocks = (static_cast<size_t>(height) + kRowBlock - 1) / kRowBlock;
  partial_.assign(blocks, 0.0);
  parallel_for(static_cast<size_t>(height), kRowBlock, [&](size_t begin, size_t end) {
    std::vector<float> blurred[5];
    for (auto& row : blurred) row.resize(row_width);
    std::vector<float> padded[3];
    for (auto& row : padded) row.assign(row_width + 2 * kReach, 0.0f);
    std::vector<float> values(row_width);
    double sum = 0;
    for (size_t row = begin; row < end; ++row) {
      for (int plane = 0; plane < 5; ++plane)
        blur_column(rows_[plane].data(), width, height, static_cast<int>(row), blurred[plane].data());
      const float *mx = blurred[0].data(), *my = blurred[1].data();
      const float *xx = blurred[2].data(), *yy = blurred[3].data(), *xy = blurred[4].data();
      float *by_mean = padded[0].data() + kReach, *by_square = padded[1].data() + kReach;
      float *by_product = padded[2].data() + kReach, *value = values.data();
      for (int i = 0; i < width; ++i) {
        const float a1 = 2 * mx[i] * my[i] + kSsimC1, a2 = 2 * (xy[i] - mx[i] * my[i]) + kSsimC2;
        const float b1 = mx[i] * mx[i] + my[i] * my[i] + kSsimC1;
        const float b2 = (xx[i] - mx[i] * mx[i]) + (yy[i] - my[i] * my[i]) + kSsimC2;
        const float over = 1.0f / (b1 * b2);
        const float s = a1 * a2 * over;
        value[i] = s;
        // By the blurred values of x, x² and x y.
        by_product[i] = 2 * a1 * over;
        by_square[i] = -s / b2;
        by_mean[i] = 2 * my[i] * (a2 - a1) * over - 2 * mx[i] * s * (1.0f / b1 - 1.0f / b2);
      }
      for (int i = 0; i < width; ++i) sum += double{value[i]};
      if (!with_gradient) continue;
      for (int map = 0; map < 3; ++map)
        blur_row(padded[map].data(), width, maps_[map].data() + row * row_width);
    }
    partial_[begin / kRowBlock] = sum;
  });
  if (with_gradient) {
    parallel_for(static_cast<size_t>(height), kRowBlock, [&](size_t begin, size_t end) {
      std::vector<float> blurred[3];
      for (auto& row : blurred) row.resize(row_width);
      for (size_t row = begin; row < end; ++row) {
        for (int map = 0; map < 3; ++map)
          blur_column(maps_[map].data(), width, height, static_cast<int>(row), blurred[map].data());
        const float *mean = blurred[0].data(), *square = blurred[1].data(), *product = blurred[2].data();
        const float *px = x + row * row_width, *py = y + row * row_width;
        float* out = by_x + row * row_width;
        for (int i = 0; i < width; ++i)
          out[i] += scale * (mean[i] + 2 * px[i] * square[i] + py[i] * product[i]);
      }
    });
  }
  double sum = 0;
  for (double part : partial_) sum += part;
  return sum / static_cast<double>(count);
}

double PictureLoss::evaluate(const PicturePlanes& picture, const PicturePlanes& target,
                             std::span<const uint8_t> counts, float alpha_weight, PicturePlanes& by_picture) {
  const size_t count = picture.pixels();
  by_picture.resize(picture.width, picture.height);
  double loss = 0;
  const auto seen = colours_of(picture);
  const auto wanted = colours_of(target);
  const auto by = colours_of(by_picture);
  const float share = (1 - kSsimWeight) / (3 * static_cast<float>(count));
  constexpr size_t kPixelBlock = 8192;
  for (size_t colour = 0; colour < 3; ++colour) {
    const float* x = seen[colour];
    if (!counts.empty()) {
      // Ignored pixels are equal in both pictures.
      clamped_.resize(count);
      for (size_t i = 0; i < count; ++i) clamped_[i] = counts[i] != 0 ? x[i] : wanted[colour][i];
      x = clamped_.data();
    }
    partial_.assign((count + kPixelBlock - 1) / kPixelBlock, 0.0);
    parallel_for(count, kPixelBlock, [&](size_t begin, size_t end) {
      double sum = 0;
      const float* y = wanted[colour];
      float* out = by[colour];
      for (size_t i = begin; i < end; ++i) {
        const float difference = x[i] - y[i];
        sum += double{std::abs(difference)};
        out[i] = difference > 0 ? share : (difference < 0 ? -share : 0.0f);
      }
      partial_[begin / kPixelBlock] = sum;
    });
    double sum = 0;
    for (double part : partial_) sum += part;
    loss += double{share} * sum;
    const double similarity = plane_ssim(x, wanted[colour], picture.width, picture.height, true, by[colour],
                                         -kSsimWeight / (3 * static_cast<float>(count)));
    loss += double{kSsimWeight} / 3 * (1 - similarity);
    if (!counts.empty()) {
      for (size_t i = 0; i < count; ++i) by[colour][i] = counts[i] != 0 ? by[colour][i] : 0.0f;
    }
  }
  const float alpha_share = alpha_weight / static_cast<float>(count);
  double alpha_loss = 0;
  for (size_t i = 0; i < count; ++i) {
    const float difference = picture.alpha[i] - target.alpha[i];
    const bool counted = counts.empty() || counts[i] != 0;
    if (counted) alpha_loss += double{std::abs(difference)};
    by_picture.alpha[i] = !counted || difference == 0 ? 0.0f : (difference > 0 ? alpha_share : -alpha_share);
  }
  return loss + double{alpha_share} * alpha_loss;
}

double PictureLoss::ssim(const PicturePlanes& picture, const PicturePlanes& target) {
  double sum = 0;
  const auto seen = colours_of(picture);
  const auto wanted = colours_of(target);
  for (size_t colour = 0; colour < 3; ++colour) {
    clamped_.assign(seen[colour], seen[colour] + picture.pixels());
    for (float& value : clamped_) value = std::clamp(value, 0.0f, 1.0f);
    sum += plane_ssim(clamped_.data(), wanted[colour], picture.width, picture.height, false, nullptr, 0);
  }
  return sum / 3;
}

double psnr_db(const PicturePlanes& picture, const PicturePlanes& target, std::span<const uint8_t> counts) {
  double sum = 0;
  size_t counted = 0;
  const auto seen = colours_of(picture);
  const auto wanted = colours_of(target);
  for (size_t i = 0; i < picture.pixels(); ++i) {
    if (!counts.empty() && counts[i] == 0) continue;
    ++counted;
    for (size_t colour = 0; colour < 3; ++colour) {
      const double difference = std::clamp(double{seen[colour][i]}, 0.0, 1.0) - double{wanted[colour][i]};
      sum += difference * difference;
    }
  }
  if (sum == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(3 * static_cast<double>(counted) / sum);
}

}  // namespace livegs

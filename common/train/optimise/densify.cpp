// SPDX-License-Identifier: Apache-2.0
#include "train/optimise/densify.h"

#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"
#include "gaussian/opacity.h"
#include "train/optimise/random_number.h"

namespace livegs {
namespace {

constexpr size_t kNoiseBlock = 1024;  // kernels
// Noise per learning rate of the positions, and steepness of its fall with opacity (the authors' values).
constexpr double kNoise = 5e5, kNoiseSteepness = 100;
// Above this opacity the noise is under 1e-6 of its maximum and is left out.
constexpr float kNoiseLimit = 0.15f;

// Streams of random numbers; the step is added in the high bits.
enum Stream : uint64_t { kRelocateStream = 1, kGrowStream = 2, kNoiseStream = 3 };
uint64_t stream_of(Stream stream, uint64_t step) { return step << 8 | stream; }

double opacity_of(const KernelParameters& parameters, size_t kernel) {
  return 1 / (1 + std::exp(-double{*parameters.row(Family::Opacity, kernel)}));
}

bool is_finite(const KernelParameters& parameters, size_t kernel) {
  for (size_t f = 0; f < kFamilies; ++f) {
    const float* row = parameters.row(static_cast<Family>(f), kernel);
    for (size_t i = 0; i < kFamilyWidth[f]; ++i) {
      if (!std::isfinite(row[i])) return false;
    }
  }
  const float* q = parameters.row(Family::Rotation, kernel);
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] > 1e-8f;
}

void copy_row(const KernelParameters& from, size_t source, KernelParameters& to, size_t target) {
  for (size_t f = 0; f < kFamilies; ++f) {
    const auto family = static_cast<Family>(f);
    std::copy_n(from.row(family, source), kFamilyWidth[f], to.row(family, target));
  }
}

void become_copies(KernelParameters& parameters, size_t kernel, int copies) {
  const CopiedKernel copied = copied_kernel(opacity_of(parameters, kernel), copies);
  const double opacity = std::clamp(copied.opacity, kDeadOpacity, 1 - 1e-6);
  *parameters.row(Family::Opacity, kernel) = static_cast<float>(std::log(opacity / (1 - opacity)));
  const auto shift = static_cast<float>(std::log(copied.scale_factor));
  for (int i = 0; i < 3; ++i) parameters.row(Family::LogScale, kernel)[i] += shift;
}

// Draws `draws` of the kernels with weights; returns the number of draws of each.
std::vector<size_t> draw(const std::vector<double>& weights, size_t draws, uint64_t seed, uint64_t stream) {
  std::vector<double> upto(weights.size());
  double sum = 0;
  for (size_t k = 0; k < weights.size(); ++k) upto[k] = sum += weights[k];
  std::vector<size_t> drawn(draws);
  for (size_t i = 0; i < draws; ++i) {
    const double at = random_share(seed, stream, i) * sum;
    const auto found = std::upper_bound(upto.begin(), upto.end(), at);
    drawn[i] = std::min(static_cast<size_t>(found - upto.begin()), weights.size() - 1);
  }
  return drawn;
}

}  // namespace

CopiedKernel copied_kernel(double opacity, int copies) {
  const double each = 1 - std::pow(1 - opacity, 1.0 / copies);
  double sum = 0;
  for (int i = 1; i <= copies; ++i) {
    double binomial = 1, power = each;  // C(i - 1, k) and each^(k + 1)
    for (int k = 0; k < i; ++k) {
      sum += (k % 2 == 0 ? 1 : -1) * binomial * power / std::sqrt(k + 1.0);
      binomial *= static_cast<double>(i - 1 - k) / (k + 1);
      power *= each;
    }
  }
  return {each, opacity / sum};
}

size_t relocate_dead(uint64_t seed, uint64_t step, KernelParameters& parameters, AdamState& adam) {
  std::vector<size_t> dead;
  std::vector<double> weights(parameters.size());
  double sum = 0;
  for (size_t k = 0; k < parameters.size(); ++k) {
    const bool good = is_finite(parameters, k);
    const double opacity = good ? opacity_of(parameters, k) : 0;
    if (!good || opacity <= kDeadOpacity) {
      dead.push_back(k);
    } else {
      sum += weights[k] = opacity;
    }
  }
  if (dead.empty() || !(sum > 0)) return 0;
  const std::vector<size_t> drawn = draw(weights, dead.size(), seed, stream_of(kRelocateStream, step));
  std::vector<int> copies(parameters.size(), 1);
  for (size_t source : drawn) copies[source] = std::min(copies[source] + 1, kMaxCopies);
  for (size_t k = 0; k < parameters.size(); ++k) {
    if (copies[k] == 1) continue;
    become_copies(parameters, k, copies[k]);
    adam.clear_row(k);
  }
  for (size_t i = 0; i < dead.size(); ++i) {
    copy_row(parameters, drawn[i], parameters, dead[i]);
    adam.clear_row(dead[i]);
  }
  return dead.size();
}

size_t grow(uint64_t seed, uint64_t step, size_t cap, KernelParameters& parameters, AdamState& adam) {
  const size_t count = parameters.size();
  const size_t wanted =
      std::min(cap, count + static_cast<size_t>(std::ceil(kGrowth * static_cast<double>(count))));
  if (wanted <= count) return 0;
  std::vector<double> weights(count);
  for (size_t k = 0; k < count; ++k) weights[k] = opacity_of(parameters, k);
  const std::vector<size_t> drawn = draw(weights, wanted - count, seed, stream_of(kGrowStream, step));
  std::vector<int> copies(count, 1);
  for (size_t source : drawn) copies[source] = std::min(copies[source] + 1, kMaxCopies);
  for (size_t k = 0; k < count; ++k) {
    if (copies[k] == 1) continue;
    become_copies(parameters, k, copies[k]);
    adam.clear_row(k);
  }
  parameters.resize(wanted);
  adam.resize(wanted);
  for (size_t i = 0; i < drawn.size(); ++i) copy_row(parameters, drawn[i], parameters, count + i);
  return drawn.size();
}

void add_noise(uint64_t seed, uint64_t step, double rate, KernelParameters& parameters) {
  const auto scale = static_cast<float>(kNoise * rate);
  const uint64_t stream = stream_of(kNoiseStream, step);
  parallel_for(parameters.size(), kNoiseBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const float opacity = opacity_of_logit(*parameters.row(Family::Opacity, k));
      if (!(opacity < kNoiseLimit)) continue;
      const auto steepness = static_cast<float>(kNoiseSteepness);
      const float strength = scale / (1 + std::exp(steepness * (opacity - static_cast<float>(kDeadOpacity))));
      float normal[4];
      random_normals(seed, stream, 2 * k, normal[0], normal[1]);
      random_normals(seed, stream, 2 * k + 1, normal[2], normal[3]);
      const float* q = parameters.row(Family::Rotation, k);
      const Eigen::Matrix3f rotation =
          Eigen::Quaternionf(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
      const float* log_scale = parameters.row(Family::LogScale, k);
      Eigen::Vector3f along = rotation.transpose() * Eigen::Vector3f(normal[0], normal[1], normal[2]);
      for (int i = 0; i < 3; ++i) along[i] *= std::exp(2 * log_scale[i]);
      const Eigen::Vector3f shift = strength * (rotation * along);
      float* position = parameters.row(Family::Position, k);
      for (int i = 0; i < 3; ++i) position[i] += shift[i];
    }
  });
}

}  // namespace livegs

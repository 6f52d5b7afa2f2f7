// SPDX-License-Identifier: Apache-2.0
#include "train/optimise/densify.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

// Draws up to `count` different kernels with weights (Efraimidis and Spirakis 2006). Those without weight are
// never drawn. In increasing order.
std::vector<size_t> draw(const std::vector<float>& weights, size_t count, uint64_t seed, uint64_t stream) {
  std::vector<std::pair<double, size_t>> keys;
  for (size_t k = 0; k < weights.size(); ++k) {
    if (!(weights[k] > 0)) continue;
    keys.emplace_back(-std::log1p(-random_share(seed, stream, k)) / double{weights[k]}, k);
  }
  if (keys.size() > count) {
    std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(count), keys.end());
    keys.resize(count);
  }
  std::vector<size_t> drawn;
  for (const auto& [key, k] : keys) drawn.push_back(k);
  std::sort(drawn.begin(), drawn.end());
  return drawn;
}

// The halves of a kernel take its place and `second`.
void split(KernelParameters& parameters, size_t kernel, size_t second, std::vector<float>& errors,
           AdamState& adam) {
  float* log_scale = parameters.row(Family::LogScale, kernel);
  const auto axis = std::max_element(log_scale, log_scale + 3) - log_scale;
  const float* q = parameters.row(Family::Rotation, kernel);
  const Eigen::Vector3f offset =
      static_cast<float>(kSplitOffset) * std::exp(log_scale[axis]) *
      Eigen::Quaternionf(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix().col(axis);
  log_scale[axis] += static_cast<float>(0.5 * std::log(1 - kSplitOffset * kSplitOffset));
  errors[kernel] *= 0.5f;
  errors[second] = errors[kernel];
  copy_row(parameters, kernel, parameters, second);
  for (int i = 0; i < 3; ++i) {
    parameters.row(Family::Position, kernel)[i] -= offset[i];
    parameters.row(Family::Position, second)[i] += offset[i];
  }
  adam.clear_row(kernel);
  adam.clear_row(second);
}

}  // namespace

size_t relocate_dead(uint64_t seed, uint64_t step, std::vector<float>& errors, KernelParameters& parameters,
                     AdamState& adam) {
  std::vector<size_t> dead;
  for (size_t k = 0; k < parameters.size(); ++k) {
    if (is_finite(parameters, k) && opacity_of(parameters, k) > kDeadOpacity) continue;
    dead.push_back(k);
    errors[k] = 0;
  }
  const std::vector<size_t> drawn = draw(errors, dead.size(), seed, stream_of(kRelocateStream, step));
  for (size_t i = 0; i < drawn.size(); ++i) split(parameters, drawn[i], dead[i], errors, adam);
  return drawn.size();
}

size_t grow(uint64_t seed, uint64_t step, size_t cap, std::vector<float>& errors,
            KernelParameters& parameters, AdamState& adam) {
  const size_t count = parameters.size();
  const size_t wanted =
      std::min(cap, count + static_cast<size_t>(std::ceil(kGrowth * static_cast<double>(count))));
  if (wanted <= count) return 0;
  const std::vector<size_t> drawn = draw(errors, wanted - count, seed, stream_of(kGrowStream, step));
  parameters.resize(count + drawn.size());
  adam.resize(count + drawn.size());
  errors.resize(count + drawn.size());
  for (size_t i = 0; i < drawn.size(); ++i) split(parameters, drawn[i], count + i, errors, adam);
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

// SPDX-License-Identifier: Apache-2.0
#include "splat/passes/kernel_looks.h"

#include <cmath>

#include "splat/half_float.h"

namespace livegs {
namespace {

// log2 of the sigmoid, in doubles: for a faint kernel, the logarithm of a rounded opacity would be wrong.
float log2_opacity(float logit) {
  return static_cast<float>(-std::log1p(std::exp(-static_cast<double>(logit))) * M_LOG2E);
}

}  // namespace

KernelLookRow look_row(const GaussianAsset& asset, size_t kernel) {
  const Eigen::Vector3f& dc = asset.sh_dc[kernel];
  return {log2_opacity(asset.opacity_logits[kernel]), dc.x(), dc.y(), dc.z()};
}

void pack_bands(const GaussianAsset& asset, size_t kernel, std::span<uint32_t> words) {
  const size_t coefficients = asset.sh_rest_count();
  for (size_t c = 0; c < 3 * coefficients; ++c) {
    const float value = asset.sh_rest[kernel * coefficients + c / 3][static_cast<int>(c % 3)];
    words[c / 2] |= static_cast<uint32_t>(half_of_float(value)) << (16 * (c % 2));
  }
}

}  // namespace livegs

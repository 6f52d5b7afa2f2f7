// SPDX-License-Identifier: Apache-2.0
#include "common/gaussian/synthetic_asset.h"

#include <random>

namespace livegs {

GaussianAsset synthetic_asset(size_t count, int sh_degree, uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto within = [&](float low, float high) {
    return low + (high - low) * (static_cast<float>(engine() >> 40) / 16777216.0f);
  };
  const auto vector = [&](float low, float high) {
    const float x = within(low, high), y = within(low, high), z = within(low, high);
    return Eigen::Vector3f(x, y, z);
  };
  GaussianAsset asset;
  asset.sh_degree = sh_degree;
  asset.resize(count);
  for (size_t i = 0; i < count; ++i) {
    asset.positions[i] = vector(-2, 2);
    asset.log_scales[i] = vector(-9, 1);
    const Eigen::Vector3f axis = vector(-1, 1);
    asset.rotations[i] = Eigen::Quaternionf(within(-1, 1), axis.x(), axis.y(), axis.z()).normalized();
    asset.opacity_logits[i] = within(-5, 5);
    asset.sh_dc[i] = vector(-1.5f, 1.5f);
  }
  for (Eigen::Vector3f& coefficient : asset.sh_rest) coefficient = vector(-0.9f, 0.9f);
  return asset;
}

}  // namespace livegs

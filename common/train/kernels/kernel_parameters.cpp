// SPDX-License-Identifier: Apache-2.0
#include "train/kernel_parameters.h"

#include <algorithm>
#include <cmath>

namespace livegs {

GaussianAsset asset_of(const KernelParameters& parameters, int sh_degree) {
  GaussianAsset asset;
  asset.sh_degree = sh_degree;
  asset.resize(parameters.size());
  const size_t rest = asset.sh_rest_count();
  for (size_t k = 0; k < parameters.size(); ++k) {
    asset.positions[k] = Eigen::Map<const Eigen::Vector3f>(parameters.row(Family::Position, k));
    asset.log_scales[k] = Eigen::Map<const Eigen::Vector3f>(parameters.row(Family::LogScale, k));
    const float* q = parameters.row(Family::Rotation, k);
    const Eigen::Quaternionf rotation(q[0], q[1], q[2], q[3]);
    asset.rotations[k] = rotation.norm() > 1e-20f ? rotation.normalized() : Eigen::Quaternionf::Identity();
    asset.opacity_logits[k] = *parameters.row(Family::Opacity, k);
    asset.sh_dc[k] = Eigen::Map<const Eigen::Vector3f>(parameters.row(Family::Colour, k));
    const float* harmonics = parameters.row(Family::Harmonics, k);
    for (size_t i = 0; i < rest; ++i)
      asset.sh_rest[k * rest + i] = Eigen::Map<const Eigen::Vector3f>(harmonics + 3 * i);
  }
  return asset;
}

}  // namespace livegs

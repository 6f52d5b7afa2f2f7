// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Nearest-rank percentiles of a sorted list: the value at rank ceil(p/100 n).
struct Percentiles {
  float p1 = 0, p50 = 0, p99 = 0;
};

// Lengths are in the asset's own unit. All members are zero for an empty asset.
struct AssetSummary {
  size_t count = 0;
  int sh_degree = 0;
  Eigen::Vector3f bounds_min = Eigen::Vector3f::Zero();  // of the kernels' centres
  Eigen::Vector3f bounds_max = Eigen::Vector3f::Zero();
  Percentiles opacity;  // 0..1
  Percentiles scale;    // geometric mean of a kernel's three standard deviations
  double mean_opacity = 0;
};

AssetSummary summarise(const GaussianAsset& asset);

}  // namespace livegs

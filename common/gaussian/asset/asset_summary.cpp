// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset_summary.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gaussian/opacity.h"

namespace livegs {
namespace {

Percentiles percentiles(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&](size_t percent) { return values[(values.size() * percent + 99) / 100 - 1]; };
  return {at(1), at(50), at(99)};
}

}  // namespace

AssetSummary summarise(const GaussianAsset& asset) {
  AssetSummary summary;
  summary.count = asset.size();
  summary.sh_degree = asset.sh_degree;
  if (asset.size() == 0) return summary;

  summary.bounds_min = summary.bounds_max = asset.positions[0];
  for (const Eigen::Vector3f& position : asset.positions) {
    summary.bounds_min = summary.bounds_min.cwiseMin(position);
    summary.bounds_max = summary.bounds_max.cwiseMax(position);
  }
  std::vector<float> opacities(asset.size());
  std::vector<float> scales(asset.size());
  double sum = 0;
  for (size_t i = 0; i < asset.size(); ++i) {
    opacities[i] = opacity_of_logit(asset.opacity_logits[i]);
    sum += opacities[i];
    scales[i] = std::exp(asset.log_scales[i].sum() / 3);
  }
  summary.opacity = percentiles(std::move(opacities));
  summary.scale = percentiles(std::move(scales));
  summary.mean_opacity = sum / static_cast<double>(asset.size());
  return summary;
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Appends the kernels of `from` whose number `kept` accepts. The degree of harmonics becomes the larger of
// the two; coefficients that an asset lacks are 0.
template <class Kept>
void append_asset(GaussianAsset& to, const GaussianAsset& from, const Kept& kept) {
  const auto widen = [](GaussianAsset& asset, int degree) {
    const size_t before = asset.sh_rest_count();
    asset.sh_degree = degree;
    const size_t after = asset.sh_rest_count();
    std::vector<Eigen::Vector3f> wide(asset.size() * after, Eigen::Vector3f::Zero());
    for (size_t i = 0; i < asset.size(); ++i) {
      for (size_t k = 0; k < before; ++k) wide[i * after + k] = asset.sh_rest[i * before + k];
    }
    asset.sh_rest = std::move(wide);
  };
  if (from.sh_degree > to.sh_degree) widen(to, from.sh_degree);
  const size_t own = from.sh_rest_count(), rest = to.sh_rest_count();
  for (size_t i = 0; i < from.size(); ++i) {
    if (!kept(i)) continue;
    to.positions.push_back(from.positions[i]);
    to.log_scales.push_back(from.log_scales[i]);
    to.rotations.push_back(from.rotations[i]);
    to.opacity_logits.push_back(from.opacity_logits[i]);
    to.sh_dc.push_back(from.sh_dc[i]);
    for (size_t k = 0; k < rest; ++k)
      to.sh_rest.push_back(k < own ? from.sh_rest[i * own + k] : Eigen::Vector3f(Eigen::Vector3f::Zero()));
  }
  to.antialiased |= from.antialiased;
}

}  // namespace livegs

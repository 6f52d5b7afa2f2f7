// SPDX-License-Identifier: Apache-2.0
#include "render/renderer/most_visible_kernels.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace livegs {

std::vector<uint32_t> most_visible_kernels(const GaussianAsset& asset, size_t count) {
  std::vector<uint32_t> kernels(asset.size());
  std::iota(kernels.begin(), kernels.end(), 0u);
  if (count >= kernels.size()) return kernels;
  std::vector<double> shows(asset.size());  // logarithm of the visibility
  for (size_t i = 0; i < shows.size(); ++i) {
    const Eigen::Vector3f& size = asset.log_scales[i];
    shows[i] =
        size.sum() - size.minCoeff() - std::log1p(std::exp(-static_cast<double>(asset.opacity_logits[i])));
  }
  const auto more = [&](uint32_t a, uint32_t b) {
    return shows[a] != shows[b] ? shows[a] > shows[b] : a < b;
  };
  std::nth_element(kernels.begin(), kernels.begin() + static_cast<std::ptrdiff_t>(count), kernels.end(),
                   more);
  kernels.resize(count);
  std::sort(kernels.begin(), kernels.end());
  return kernels;
}

}  // namespace livegs

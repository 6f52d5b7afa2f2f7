// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/label/choose_kernels.h"

namespace livegs {

void append_kernel(GaussianAsset& to, const GaussianAsset& from, size_t k) {
  to.positions.push_back(from.positions[k]);
  to.log_scales.push_back(from.log_scales[k]);
  to.rotations.push_back(from.rotations[k]);
  to.opacity_logits.push_back(from.opacity_logits[k]);
  to.sh_dc.push_back(from.sh_dc[k]);
  const size_t rest = from.sh_rest_count();
  to.sh_rest.insert(to.sh_rest.end(), from.sh_rest.begin() + static_cast<std::ptrdiff_t>(k * rest),
                    from.sh_rest.begin() + static_cast<std::ptrdiff_t>((k + 1) * rest));
}

GaussianAsset select_kernels(const GaussianAsset& asset, std::span<const uint32_t> kernels) {
  GaussianAsset out;
  out.sh_degree = asset.sh_degree;
  out.antialiased = asset.antialiased;
  for (const uint32_t k : kernels) append_kernel(out, asset, k);
  return out;
}

}  // namespace livegs

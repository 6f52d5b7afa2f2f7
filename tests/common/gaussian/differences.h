// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// The largest difference of each property between kernels that belong together. The colour of a kernel of
// opacity 0 is not compared: nobody sees it, and WebP encoders save the bytes.
struct Differences {
  float position = 0;  // of a coordinate
  float log_scale = 0;
  float rotation_deg = 0;
  float opacity = 0;  // not of its logit
  float sh_dc = 0;
  float sh1 = 0;
  float sh_rest = 0;          // degrees 2 and 3
  double mean_log_scale = 0;  // mean absolute difference, of one component
  double mean_sh_dc = 0;
  double mean_sh = 0;  // of degrees 1 to 3
};

// partner[i] is the kernel of `b` that belongs to kernel i of `a`. Both have the same SH degree.
Differences differences(const GaussianAsset& a, const GaussianAsset& b, const std::vector<size_t>& partner);

std::vector<size_t> same_order(size_t count);

// For each kernel of `a` one of `b`, each taken once: the nearest in position within `radius` and then in
// colour and size. Formats that reorder are compared through it. Empty if a kernel finds none.
std::vector<size_t> match_by_position(const GaussianAsset& a, const GaussianAsset& b, float radius);

}  // namespace livegs

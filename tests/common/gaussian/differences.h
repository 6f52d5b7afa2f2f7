// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// The largest difference of each property between corresponding kernels. Colours of kernels with opacity 0
// are not compared, because WebP encoders discard them.
struct Differences {
  float position = 0;  // of one coordinate
  float log_scale = 0;
  float rotation_deg = 0;
  float opacity = 0;  // not of the logit
  float sh_dc = 0;
  float sh1 = 0;
  float sh_rest = 0;          // degrees 2 and 3
  double mean_log_scale = 0;  // mean absolute difference, of one component
  double mean_sh_dc = 0;
  double mean_sh = 0;  // of degrees 1 to 3
};

// Kernel partner[i] of `b` corresponds to kernel i of `a`. Both assets have the same SH degree.
Differences differences(const GaussianAsset& a, const GaussianAsset& b, const std::vector<size_t>& partner);

std::vector<size_t> same_order(size_t count);

// Matches each kernel of `a` to a unique kernel of `b`: the nearest in position within `radius`, then in
// colour and size. Used for formats that reorder. Empty if a kernel has no match.
std::vector<size_t> match_by_position(const GaussianAsset& a, const GaussianAsset& b, float radius);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Successive kernels that an asset has in common with its base, by their first kernel.
struct KeptRun {
  uint32_t of_base = 0, of_asset = 0, length = 0;
};
struct AssetDifference {
  std::vector<KeptRun> runs;    // ascending in the asset; a kernel of the base is in one run at most
  std::vector<uint32_t> added;  // kernels of the asset outside the runs, ascending
};

// Compares the bits of the kernels. A kernel of the asset matches the next unmatched equal kernel of the base
// after the previous match, or the first one of all. Takes O(n log n) unless many kernels of the base differ
// in their higher harmonics only. Precondition: equal degrees.
AssetDifference compare_assets(const GaussianAsset& base, const GaussianAsset& asset);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Indices of the `count` most visible kernels, ascending; all kernels if there are fewer. Visibility is
// opacity times the product of the two longest axes. At equal visibility the lower index is chosen. Pure; any
// thread.
std::vector<uint32_t> most_visible_kernels(const GaussianAsset& asset, size_t count);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// The `count` most visible kernels of an asset, or all: ranked by opacity times the product of the two
// longest axes. Indices ascend. Ties go to the lower index.
std::vector<uint32_t> most_visible_kernels(const GaussianAsset& asset, size_t count);

}  // namespace livegs

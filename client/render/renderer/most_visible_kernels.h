// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// The kernels of an asset that show most, `count` of them at most: by opacity times the product of their two
// longest axes. Ascending. Of equals the first.
std::vector<uint32_t> most_visible_kernels(const GaussianAsset& asset, size_t count);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Numbers of the kernels in Morton order (Morton 1966): along a curve through a grid of 2^21 cells an axis,
// so that neighbours in the order are neighbours in space. Kernels of one cell keep their order.
std::vector<uint32_t> morton_order(const GaussianAsset& asset);

}  // namespace livegs

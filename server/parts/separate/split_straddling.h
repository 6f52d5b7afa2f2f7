// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"

namespace livegs {

// A room whose kernels lie on one side of each border. The original kernels come first, in their order; those
// that were split are replaced by their part on the side of their label. All parts drawn together equal the
// original room up to the approximation of a cut Gaussian by one with its moments.
struct SplitRoom {
  GaussianAsset asset;
  std::vector<uint16_t> label;   // per kernel
  std::vector<uint32_t> source;  // per kernel: index in the original room
  size_t split_count = 0;        // original kernels that were split
};

// Splits kernels of a thing that reach below its support at the support, and kernels between two labels at
// the plane that separates the labels of their neighbours (server/geometry/fracture/split_gaussian.h).
// Kernels that are narrower than a pixel across the border stay whole. Deterministic.
SplitRoom split_straddling(const GaussianAsset& asset, const RoomParts& parts);

}  // namespace livegs

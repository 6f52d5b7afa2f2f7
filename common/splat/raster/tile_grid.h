// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "splat/project/projected_kernel.h"

namespace livegs {

struct TileGrid {
  int width, height;  // px
  int columns() const { return (width + kTileSize - 1) / kTileSize; }
  int rows() const { return (height + kTileSize - 1) / kTileSize; }
  size_t size() const { return static_cast<size_t>(columns()) * rows(); }
};

// The pixels of one strip of tiles that may be inside an ellipse: tile columns first..last, empty if first >
// last. `row` is the tile row of the strip.
struct TileSpan {
  int first, last;
};

}  // namespace livegs

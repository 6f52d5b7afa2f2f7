// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "splat/project/projected_kernel.h"

namespace livegs {

struct TileGrid {
  int width, height;  // px
  int columns() const { return (width + kTileSize - 1) / kTileSize; }
  int rows() const { return (height + kTileSize - 1) / kTileSize; }
  size_t size() const { return static_cast<size_t>(columns()) * rows(); }
};

// The pixels of one strip of tiles whose centres an ellipse's rim can hold: tile columns first..last, none
// where first > last. `row` is the strip's tile row.
struct TileSpan {
  int first, last;
};
TileSpan ellipse_tile_span(const ProjectedKernel& kernel, const TileGrid& grid, int row);

// For each tile, which kernels touch it, in the order they were given.
class TileBins {
 public:
  // `order` holds indices into `kernels`, nearest first. Tiles whose entry in `live` is 0 get nothing.
  void fill(std::span<const ProjectedKernel> kernels, std::span<const uint32_t> order, const TileGrid& grid,
            std::span<const uint32_t> live);

  std::span<const uint32_t> of_tile(size_t tile) const {
    return std::span(kernels_).subspan(first_[tile], first_[tile + 1] - first_[tile]);
  }

 private:
  struct Touch {
    uint32_t tile, kernel;
  };
  // What one run of kernels touches; runs are filled in parallel and then merged in order.
  struct Run {
    std::vector<Touch> touches;
    std::vector<uint32_t> next;  // a tile's count, then the place of its next kernel
  };
  std::vector<Run> runs_;
  std::vector<uint32_t> first_;
  std::vector<uint32_t> kernels_;
};

}  // namespace livegs

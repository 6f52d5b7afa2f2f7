// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "splat/project/projected_kernel.h"
#include "splat/raster/tile_grid.h"

namespace livegs {

// The tile columns of `row` that the ellipse of `kernel` may touch.
TileSpan ellipse_tile_span(const ProjectedKernel& kernel, const TileGrid& grid, int row);

// The kernels that touch each tile, in the given order.
class TileBins {
 public:
  // `order` lists indices of `kernels`, nearest first. Tiles with a 0 in `live` stay empty.
  void fill(std::span<const ProjectedKernel> kernels, std::span<const uint32_t> order, const TileGrid& grid,
            std::span<const uint32_t> live);

  std::span<const uint32_t> of_tile(size_t tile) const {
    return std::span(kernels_).subspan(first_[tile], first_[tile + 1] - first_[tile]);
  }

 private:
  struct Touch {
    uint32_t tile, kernel;
  };
  // Tile coverage of one run of kernels. Runs are filled in parallel and then merged in order.
  struct Run {
    std::vector<Touch> touches;
    std::vector<uint32_t> next;  // count of a tile, then the position of its next kernel
  };
  std::vector<Run> runs_;
  std::vector<uint32_t> first_;
  std::vector<uint32_t> kernels_;
};

}  // namespace livegs

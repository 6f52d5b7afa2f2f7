// SPDX-License-Identifier: Apache-2.0
#include "splat/raster/bin_tiles.h"

#include "core/parallel_for.h"
#include "splat/raster/ellipse_rim.h"

namespace livegs {
namespace {

constexpr size_t kRun = 4096;        // kernels
constexpr size_t kBinPrefetch = 16;  // prefetch distance in kernels

}  // namespace

TileSpan ellipse_tile_span(const ProjectedKernel& kernel, const TileGrid& grid, int row) {
  return EllipseRim(kernel, kernel.rim()).span(grid, row);
}

void TileBins::fill(std::span<const ProjectedKernel> kernels, std::span<const uint32_t> order,
                    const TileGrid& grid, std::span<const uint32_t> live) {
  const size_t tile_count = grid.size();
  const size_t run_count = (order.size() + kRun - 1) / kRun;
  if (runs_.size() < run_count) runs_.resize(run_count);
  const int columns = grid.columns();

  parallel_for(order.size(), kRun, [&](size_t begin, size_t end) {
    Run& run = runs_[begin / kRun];
    run.touches.clear();
    run.next.assign(tile_count, 0);
    for (size_t i = begin; i < end; ++i) {
      // Depth order gives random memory accesses. The prefetch hides their latency.
      if (i + kBinPrefetch < end) __builtin_prefetch(&kernels[order[i + kBinPrefetch]]);
      const uint32_t kernel = order[i];
      const auto touch = [&](uint32_t tile) {
        if (live[tile] == 0) return;
        run.touches.push_back({tile, kernel});
        ++run.next[tile];
      };
      if (kernels[kernel].tile_bound == 1) {  // most kernels; they need no rim
        touch(kernels[kernel].tile);
        continue;
      }
      const EllipseRim rim(kernels[kernel], kernels[kernel].rim());
      const TileSpan pixel_rows = rim.rows(grid);
      if (pixel_rows.first > pixel_rows.last) continue;
      const int last_row = pixel_rows.last / kTileSize;
      for (int row = pixel_rows.first / kTileSize; row <= last_row; ++row) {
        const TileSpan span = rim.span(grid, row);
        for (int column = span.first; column <= span.last; ++column)
          touch(static_cast<uint32_t>(row * columns + column));
      }
    }
  });

  first_.resize(tile_count + 1);
  uint32_t next = 0;
  for (size_t tile = 0; tile < tile_count; ++tile) {
    first_[tile] = next;
    for (size_t r = 0; r < run_count; ++r) {
      const uint32_t count = runs_[r].next[tile];
      runs_[r].next[tile] = next;
      next += count;
    }
  }
  first_[tile_count] = next;
  kernels_.resize(next);
  parallel_for(run_count, 1, [&](size_t begin, size_t) {
    Run& run = runs_[begin];
    for (const Touch& touch : run.touches) kernels_[run.next[touch.tile]++] = touch.kernel;
  });
}

}  // namespace livegs

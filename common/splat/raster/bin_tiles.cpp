// SPDX-License-Identifier: Apache-2.0
#include "splat/raster/bin_tiles.h"

#include <algorithm>
#include <cmath>

#include "core/parallel_for.h"

namespace livegs {
namespace {

constexpr size_t kRun = 4096;        // kernels
constexpr size_t kBinPrefetch = 16;  // prefetch distance in kernels

// First and last pixel with its centre in [begin, end], clamped to [0, size).
TileSpan pixels_between(float begin, float end, int size) {
  const float last = static_cast<float>(size);
  return {static_cast<int>(std::ceil(std::clamp(begin - 0.5f, 0.0f, last))),
          static_cast<int>(std::floor(std::clamp(end - 0.5f, -1.0f, last - 1.0f)))};
}

// The ellipse in the frame of its triangular root: v runs over the rows. At v, the rim is at
// x = centre + (-slope v ± sqrt(rim - v²)) / across_x.
struct Rim {
  explicit Rim(const ProjectedKernel& kernel)
      : centre_x(kernel.centre_x_px),
        centre_y(kernel.centre_y_px),
        down_y(kernel.down_y),
        slope(kernel.across_y / kernel.down_y),
        width(1.0f / kernel.across_x),
        rim(kernel.rim()),
        reach(std::sqrt(rim)),
        v_rightmost(-slope * reach / std::sqrt(1.0f + slope * slope)) {}

  TileSpan rows(const TileGrid& grid) const {
    const float reach_y = reach / down_y;
    return pixels_between(centre_y - reach_y, centre_y + reach_y, grid.height);
  }

  TileSpan span(const TileGrid& grid, int row) const {
    const int bottom = std::min(row * kTileSize + kTileSize, grid.height);
    const float v_top = (static_cast<float>(row * kTileSize) + 0.5f - centre_y) * down_y;
    const float v_bottom = (static_cast<float>(bottom) - 0.5f - centre_y) * down_y;
    if (v_top > reach || v_bottom < -reach) return {1, 0};
    const auto held = [&](float v) { return std::clamp(v, v_top, v_bottom); };
    const auto half = [&](float v) { return std::sqrt(std::max(0.0f, rim - v * v)); };
    // The right rim rises up to v_rightmost and falls after it; the left rim is its mirror image.
    const float v_right = held(v_rightmost), v_left = held(-v_rightmost);
    const TileSpan pixels = pixels_between(centre_x + (-slope * v_left - half(v_left)) * width,
                                           centre_x + (-slope * v_right + half(v_right)) * width, grid.width);
    if (pixels.first > pixels.last) return {1, 0};
    return {pixels.first / kTileSize, pixels.last / kTileSize};
  }

  float centre_x, centre_y, down_y, slope, width, rim, reach, v_rightmost;
};

}  // namespace

TileSpan ellipse_tile_span(const ProjectedKernel& kernel, const TileGrid& grid, int row) {
  return Rim(kernel).span(grid, row);
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
      const Rim rim(kernels[kernel]);
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

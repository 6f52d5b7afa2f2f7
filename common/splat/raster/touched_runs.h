// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "splat/project/projected_kernel.h"
#include "splat/raster/lanes.h"

namespace livegs {

// Margin of the rim, in powers of two of alpha, so that rounding drops no pixel. The alpha of a pixel decides
// whether it counts.
inline constexpr float kRimMargin = 1e-3f;

// A kernel in the frame of a tile: `u` and `v` at the first pixel of the tile.
struct TileKernel {
  TileKernel(const ProjectedKernel& k, float tile_x, float tile_y)
      : dx(tile_x + 0.5f - k.centre_x_px), dy(tile_y + 0.5f - k.centre_y_px) {}
  float dx, dy;
};

// Runs of a tile that the ellipse touches where u² + v² is at most `rim`. The 256 pixels of a tile are 32
// runs of eight: run b is row b % 16, left half for b < 16, right half otherwise.
inline uint32_t touched_runs(const ProjectedKernel& kernel, const TileKernel& placed, float rim) {
  rim += kRimMargin;
  const float width = 1.0f / kernel.across_x;
  uint32_t runs = 0;
  for (int half = 0; half < 2; ++half) {
    const Lanes dy = placed.dy + (8.0f * static_cast<float>(half) + lane_indices());
    const Lanes v = kernel.down_y * dy;
    const Lanes left_over = rim - v * v;
    const Lanes reach = sqrt(max(left_over, lanes(0.0f))) * width;
    // of the rim, relative to the first pixel
    const Lanes middle = -(kernel.across_y * width) * dy - placed.dx;
    const LaneMask in_rows = left_over >= 0.0f;
    const Lanes first = middle - reach, last = middle + reach;
    // A margin of half a pixel at both ends, for the rounding of centres far outside the screen.
    const uint32_t left_runs = mask_bits(in_rows & (first <= 7.5f) & (last >= -0.5f));
    const uint32_t right_runs = mask_bits(in_rows & (first <= 15.5f) & (last >= 7.5f));
    runs |= (left_runs << (8 * half)) | (right_runs << (16 + 8 * half));
  }
  return runs;
}

}  // namespace livegs

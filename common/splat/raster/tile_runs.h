// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "splat/project/projected_kernel.h"
#include "splat/raster/lanes.h"

// The 256 pixels of a tile are 32 runs of eight: run b is row b % 16, left half for b < 16, right half
// otherwise. A kernel is evaluated only in runs that its ellipse touches and that are not yet opaque.

namespace livegs {

inline constexpr float kMinTransmittance = 1e-4f;  // (1 - kMaxAlpha)²
inline constexpr float kHalfway = 0.5f;
inline constexpr size_t kTilesPerBlock = 4;

// Margin of the rim, in powers of two of alpha, so that rounding drops no pixel. The alpha of a pixel decides
// whether it counts.
inline constexpr float kRimMargin = 1e-3f;

// A kernel in the frame of a tile: `u` and `v` at the first pixel of the tile.
struct PlacedKernel {
  PlacedKernel(const ProjectedKernel& k, float tile_x, float tile_y)
      : dx(tile_x + 0.5f - k.centre_x_px), dy(tile_y + 0.5f - k.centre_y_px) {}
  float dx, dy;
};

inline uint32_t touched_runs(const ProjectedKernel& kernel, const PlacedKernel& placed) {
  const float rim = kernel.rim() + kRimMargin;
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

// Runs that contain at least one pixel of the image.
inline uint32_t runs_inside(int columns, int rows) {
  uint32_t runs = 0;
  for (int row = 0; row < std::min(rows, kTileSize); ++row) {
    runs |= uint32_t{1} << row;
    if (columns > 8) runs |= uint32_t{1} << (16 + row);
  }
  return runs;
}

// Index of the first pixel of a run in its tile.
inline int first_pixel_of(int run) { return (run & 15) * kTileSize + (run < 16 ? 0 : 8); }

// The alpha of a kernel in the eight pixels of a run.
class RunAlpha {
 public:
  RunAlpha(const ProjectedKernel& kernel, const PlacedKernel& placed)
      : kernel_(kernel),
        placed_(placed),
        along_run_(kernel.across_x * lane_indices()),
        u_first_(kernel.across_x * placed.dx),
        u_right_(kernel.across_x * 8.0f) {}

  Lanes operator()(int run) const {
    const float dy = placed_.dy + static_cast<float>(run & 15);
    const float v = kernel_.down_y * dy;
    const Lanes u = along_run_ + (u_first_ + kernel_.across_y * dy + (run < 16 ? 0.0f : u_right_));
    const Lanes exponent = (kernel_.log2_opacity - v * v) - u * u;
    return min(exp2(max(exponent, lanes(-64.0f))), lanes(kMaxAlpha));
  }

 private:
  const ProjectedKernel& kernel_;
  const PlacedKernel& placed_;
  Lanes along_run_;
  float u_first_, u_right_;
};

}  // namespace livegs

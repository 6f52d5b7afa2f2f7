// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "splat/project/projected_kernel.h"
#include "splat/raster/lanes.h"
#include "splat/raster/touched_runs.h"

// The 256 pixels of a tile are 32 runs of eight: run b is row b % 16, left half for b < 16, right half
// otherwise. A kernel is evaluated only in runs that its ellipse touches and that are not yet opaque.

namespace livegs {

inline constexpr float kMinTransmittance = 1e-4f;  // (1 - kMaxAlpha)²
inline constexpr float kHalfway = 0.5f;
inline constexpr size_t kTilesPerBlock = 4;

inline uint32_t touched_runs(const ProjectedKernel& kernel, const TileKernel& placed) {
  return touched_runs(kernel, placed, kernel.rim());
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
  RunAlpha(const ProjectedKernel& kernel, const TileKernel& placed)
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
  const TileKernel& placed_;
  Lanes along_run_;
  float u_first_, u_right_;
};

}  // namespace livegs

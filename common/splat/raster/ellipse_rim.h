// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "splat/project/projected_kernel.h"
#include "splat/raster/tile_grid.h"

namespace livegs {

// First and last pixel with its centre in [begin, end], clamped to [0, size).
inline TileSpan pixels_between(float begin, float end, int size) {
  const float last = static_cast<float>(size);
  return {static_cast<int>(std::ceil(std::clamp(begin - 0.5f, 0.0f, last))),
          static_cast<int>(std::floor(std::clamp(end - 0.5f, -1.0f, last - 1.0f)))};
}

// The ellipse in the frame of its triangular root: v runs over the rows. At v, the rim is at
// x = centre + (-slope v ± sqrt(rim - v²)) / across_x. rim: u² + v² there.
struct EllipseRim {
  EllipseRim(const ProjectedKernel& kernel, float rim_value)
      : centre_x(kernel.centre_x_px),
        centre_y(kernel.centre_y_px),
        down_y(kernel.down_y),
        slope(kernel.across_y / kernel.down_y),
        width(1.0f / kernel.across_x),
        rim(rim_value),
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

}  // namespace livegs

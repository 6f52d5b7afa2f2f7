// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace livegs {

inline constexpr int kTileSize = 16;  // px, the edge of a square tile of the rasteriser

inline constexpr float kMinAlpha = 1.0f / 255.0f;
inline constexpr float kMaxAlpha = 0.99f;
inline constexpr double kLowPassPx2 = 0.3;  // variance added to the projected ellipse
inline constexpr float kLog2Of255 = 7.99435344f;

// A kernel as an ellipse on the screen; one cache line. The quadratic form is stored as its triangular root,
// scaled so that alpha is a power of two. With d = pixel - centre,
//   u = across_x * d.x + across_y * d.y,   v = down_y * d.y,   alpha = 2^(log2_opacity - u² - v²).
// The root is cheaper to evaluate than the form, and needles of hundreds of pixels keep their width, which
// cancellation in a float form would lose.
struct alignas(64) ProjectedKernel {
  float centre_x_px, centre_y_px;
  float across_x, across_y, down_y;
  float log2_opacity;  // > -kLog2Of255
  float red, green, blue;
  float depth_m;  // along the view axis
  uint32_t object_slot;
  uint32_t tile_bound;  // tiles of the bounding box on the screen, at least 1
  uint32_t tile;        // the tile, if it is only one
  uint32_t kernel;      // index in its object

  // u² + v² on the rim of the ellipse, where alpha is kMinAlpha.
  float rim() const { return log2_opacity + kLog2Of255; }
};
static_assert(sizeof(ProjectedKernel) == 64);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "splat/raster/blend_tiles.h"
#include "train/render/project_trained.h"
#include "train/render/render_cuts.h"

namespace livegs {

// Pixels of one tile, row by row. Pixels outside the picture have transmittance 0.
struct alignas(32) TilePixels {
  float transmittance[kTilePixels];  // negative once the pixel has stopped
  float red[kTilePixels], green[kTilePixels], blue[kTilePixels];
  // Sums over the kernels i of a pixel with weights w and depths z of the centres, scene units: w z, and the
  // spread, w_i w_k |z_i - z_k| over all pairs (Barron et al. 2022, equation 15). Filled on request.
  float depth[kTilePixels], spread[kTilePixels];
};
// Derivatives of the loss by the pixels of a tile, and their remainders behind the current kernel.
struct alignas(32) TileGradient {
  float red[kTilePixels], green[kTilePixels], blue[kTilePixels];
  float alpha[kTilePixels];
  // Sum of weight * (gradient . colour) over all kernels behind, and the background.
  float left[kTilePixels];
  // dL by the spread, and the finished picture for it.
  float spread[kTilePixels], final_alpha[kTilePixels], final_depth[kTilePixels];
};

struct TileFrame {
  float x, y;  // first pixel
};

// Blends one kernel into `tile` in front-to-back order; returns the runs (touched_runs.h) that became opaque.
// `halfway` (may be null) receives `rank` where transmittance falls under a half.
uint32_t blend_forward(const ProjectedKernel& kernel, const TileFrame& frame, const RenderCuts& cuts,
                       uint32_t live, TilePixels& tile, bool with_spread, uint32_t* halfway, uint32_t rank);

// The same step with derivatives: `sums` receives those of the kernel in this tile.
// `with_spread`: gradient.spread and what follows it are set.
uint32_t blend_backward(const ProjectedKernel& kernel, const TileFrame& frame, const RenderCuts& cuts,
                        uint32_t live, TilePixels& tile, TileGradient& gradient, bool with_spread,
                        EllipseGradient& sums);

// Runs that contain a pixel of the picture, for a tile with this number of columns and rows inside.
uint32_t runs_of_tile(int columns, int rows);

}  // namespace livegs

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
};
// Derivatives of the loss by the pixels of a tile, and what is left of them behind the current kernel.
struct alignas(32) TileGradient {
  float red[kTilePixels], green[kTilePixels], blue[kTilePixels];
  float alpha[kTilePixels];
  float
      left[kTilePixels];  // sum of weight * (gradient . colour) of all that lies behind, with the background
};

struct TileFrame {
  float x, y;  // first pixel
};

// Blends one kernel into `tile` in front-to-back order; returns the runs (touched_runs.h) that became opaque.
// `halfway` (may be null) receives `rank` where transmittance falls under a half.
uint32_t blend_forward(const ProjectedKernel& kernel, const TileFrame& frame, const RenderCuts& cuts,
                       uint32_t live, TilePixels& tile, uint32_t* halfway, uint32_t rank);

// The same step with derivatives: `sums` receives those of the kernel in this tile.
uint32_t blend_backward(const ProjectedKernel& kernel, const TileFrame& frame, const RenderCuts& cuts,
                        uint32_t live, TilePixels& tile, TileGradient& gradient, EllipseGradient& sums);

// Runs that contain a pixel of the picture, for a tile with this number of columns and rows inside.
uint32_t runs_of_tile(int columns, int rows);

}  // namespace livegs

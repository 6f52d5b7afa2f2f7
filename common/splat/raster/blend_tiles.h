// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "splat/project/projected_kernel.h"
#include "splat/project/raster_options.h"
#include "splat/raster/bin_tiles.h"

namespace livegs {

inline constexpr int kTilePixels = kTileSize * kTileSize;

// Blending state of one tile, row by row.
struct alignas(32) TileState {
  // Remaining transmittance. A pixel that would fall below 1e-4 is finished and keeps its last value with a
  // minus sign. Pixels outside the image are 0.
  float transmittance[kTilePixels];
  float red[kTilePixels], green[kTilePixels], blue[kTilePixels];
  float depth_m[kTilePixels];
};

// Share of each object in the opacity of each pixel, for the objects that touch the tile.
struct TileShares {
  struct alignas(32) Share {
    float of_pixel[kTilePixels];
  };
  std::vector<uint32_t> slots;  // in order of first use
  std::vector<Share> shares;    // one per slot
};

// Blends front to back in any number of calls. The tiles keep their state between calls.
class TileBlender {
 public:
  // Clears all tiles. With a single object slot, shares are not stored; they equal the coverage.
  // `image_only`: as in RasteriseOptions.
  void begin(const TileGrid& grid, size_t object_slots, bool image_only);

  // The kernels of each bin must be behind all kernels blended since begin().
  void blend(std::span<const ProjectedKernel> kernels, const TileBins& bins);

  // One word per tile, one bit for each run of eight pixels that is not yet opaque.
  std::span<const uint32_t> live() const { return live_; }

  // Writes the picture. `object_ids` maps slots to ids.
  void resolve(const Eigen::Vector3f& background, std::span<const uint32_t> object_ids,
               RasterisedView& view) const;

 private:
  TileGrid grid_{};
  bool image_only_ = false;
  std::vector<TileState> tiles_;
  std::vector<TileShares> shares_;
  std::vector<uint32_t> live_;
};

}  // namespace livegs

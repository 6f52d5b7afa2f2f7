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

// What has been blended into one tile so far, row by row.
struct alignas(32) TileState {
  // Left to pass; a pixel that would let less than 1e-4 through is finished and keeps its last value with a
  // minus sign. Pixels beyond the image's edge hold 0.
  float transmittance[kTilePixels];
  float red[kTilePixels], green[kTilePixels], blue[kTilePixels];
  float depth_m[kTilePixels];
};

// How much of each pixel's opacity came from which object, for the objects that have touched the tile.
struct TileShares {
  struct alignas(32) Share {
    float of_pixel[kTilePixels];
  };
  std::vector<uint32_t> slots;  // in order of arrival
  std::vector<Share> shares;    // one a slot
};

// Blends front to back, in as many calls as it takes: the tiles keep their state in between.
class TileBlender {
 public:
  // Clears all tiles. With one object slot shares are not kept: they are the coverage.
  void begin(const TileGrid& grid, size_t object_slots);

  // The kernels of each bin lie behind all that was blended since begin.
  void blend(std::span<const ProjectedKernel> kernels, const TileBins& bins);

  // One word a tile, a bit for each run of eight pixels that still lets light through.
  std::span<const uint32_t> live() const { return live_; }

  // `object_ids` maps slots to ids.
  void resolve(const Eigen::Vector3f& background, std::span<const uint32_t> object_ids,
               RasterisedView& view) const;

 private:
  TileGrid grid_{};
  size_t object_slots_ = 0;
  std::vector<TileState> tiles_;
  std::vector<TileShares> shares_;
  std::vector<uint32_t> live_;
};

}  // namespace livegs

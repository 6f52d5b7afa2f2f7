// SPDX-License-Identifier: Apache-2.0
// Kerbl et al. 2023, section 6 and algorithm 2.
#include "splat/raster/blend_tiles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/parallel_for.h"
#include "splat/raster/lanes.h"
#include "splat/raster/tile_runs.h"

namespace livegs {
namespace {

// Blends the kernel into the live runs that it touches; returns the runs that became opaque. kShares: `share`
// receives the weights of the kernel.
template <bool kShares>
uint32_t blend_kernel(const ProjectedKernel& kernel, const TileKernel& placed, uint32_t runs, TileState& tile,
                      float* share) {
  const RunAlpha alpha_of(kernel, placed);
  uint32_t finished = 0;
  for (; runs != 0; runs &= runs - 1) {
    const int run = std::countr_zero(runs);
    const Lanes alpha = alpha_of(run);
    const int pixel = first_pixel_of(run);
    Lanes& transmittance = lanes_at(tile.transmittance + pixel);
    const Lanes before = transmittance;
    const LaneMask seen = (alpha >= kMinAlpha) & (before > 0.0f);
    if (mask_bits(seen) == 0) continue;
    const Lanes weight = alpha * before;
    const Lanes after = before - weight;
    const LaneMask stops = seen & (after < kMinTransmittance);
    const LaneMask adds = seen & ~stops;
    const Lanes added = adds ? weight : lanes(0.0f);
    lanes_at(tile.red + pixel) += added * kernel.red;
    lanes_at(tile.green + pixel) += added * kernel.green;
    lanes_at(tile.blue + pixel) += added * kernel.blue;
    if constexpr (kShares) lanes_at(share + pixel) += added;
    const LaneMask halfway = adds & (before >= kHalfway) & (after < kHalfway);
    if (mask_bits(halfway) != 0) {
      Lanes& depth = lanes_at(tile.depth_m + pixel);
      depth = halfway ? lanes(kernel.depth_m) : depth;
    }
    const Lanes left = adds ? after : (stops ? -before : before);
    transmittance = left;
    if (mask_bits(left > 0.0f) == 0) finished |= uint32_t{1} << run;
  }
  return finished;
}

float* share_of(TileShares& shares, uint32_t slot) {
  // Neighbours in depth are mostly of the same object, so the search starts with the last one.
  for (size_t i = shares.slots.size(); i-- > 0;) {
    if (shares.slots[i] == slot) return shares.shares[i].of_pixel;
  }
  shares.slots.push_back(slot);
  shares.shares.push_back({});
  return shares.shares.back().of_pixel;
}

}  // namespace

void TileBlender::begin(const TileGrid& grid, size_t object_slots, bool image_only) {
  grid_ = grid;
  image_only_ = image_only;
  tiles_.resize(grid.size());
  live_.resize(grid.size());
  shares_.resize(object_slots > 1 && !image_only ? grid.size() : 0);
  for (TileShares& shares : shares_) {
    shares.slots.clear();
    shares.shares.clear();
  }
  parallel_for(grid.size(), 64, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const int columns = grid.width - static_cast<int>(t % grid.columns()) * kTileSize;
      const int rows = grid.height - static_cast<int>(t / grid.columns()) * kTileSize;
      TileState& tile = tiles_[t];
      live_[t] = runs_inside(columns, rows);
      std::fill_n(tile.red, kTilePixels, 0.0f);
      std::fill_n(tile.green, kTilePixels, 0.0f);
      std::fill_n(tile.blue, kTilePixels, 0.0f);
      std::fill_n(tile.depth_m, kTilePixels, std::numeric_limits<float>::infinity());
      for (int i = 0; i < kTilePixels; ++i) {
        tile.transmittance[i] = i % kTileSize < columns && i / kTileSize < rows ? 1.0f : 0.0f;
      }
    }
  });
}

void TileBlender::blend(std::span<const ProjectedKernel> kernels, const TileBins& bins) {
  parallel_for(grid_.size(), kTilesPerBlock, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const std::span<const uint32_t> bin = bins.of_tile(t);
      const float tile_x = static_cast<float>(t % grid_.columns() * kTileSize);
      const float tile_y = static_cast<float>(t / grid_.columns() * kTileSize);
      uint32_t live = live_[t];
      for (size_t i = 0; i < bin.size() && live != 0; ++i) {
        // The bins access kernels in random order, which hardware prefetching cannot predict.
        if (i + 8 < bin.size()) __builtin_prefetch(&kernels[bin[i + 8]]);
        const ProjectedKernel& kernel = kernels[bin[i]];
        const TileKernel placed(kernel, tile_x, tile_y);
        const uint32_t runs = touched_runs(kernel, placed, kernel.rim()) & live;
        if (runs == 0) continue;
        live &= ~(shares_.empty() ? blend_kernel<false>(kernel, placed, runs, tiles_[t], nullptr)
                                  : blend_kernel<true>(kernel, placed, runs, tiles_[t],
                                                       share_of(shares_[t], kernel.object_slot)));
      }
      live_[t] = live;
    }
  });
}

void TileBlender::resolve(const Eigen::Vector3f& background, std::span<const uint32_t> object_ids,
                          RasterisedView& view) const {
  const auto largest_share = [&](size_t tile, int i) {
    if (shares_.empty()) return object_ids[0];
    const TileShares& shares = shares_[tile];
    size_t best = 0;
    for (size_t s = 1; s < shares.slots.size(); ++s) {
      const float lead = shares.shares[s].of_pixel[i] - shares.shares[best].of_pixel[i];
      if (lead > 0.0f || (lead == 0.0f && shares.slots[s] < shares.slots[best])) best = s;
    }
    return object_ids[shares.slots[best]];
  };
  const size_t columns = grid_.columns();
  parallel_for(grid_.height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < static_cast<size_t>(grid_.width); ++x) {
        const size_t t = y / kTileSize * columns + x / kTileSize;
        const int i = static_cast<int>(y % kTileSize * kTileSize + x % kTileSize);
        const TileState& tile = tiles_[t];
        const float transmittance = std::abs(tile.transmittance[i]);
        const size_t pixel = y * grid_.width + x;
        float* rgba = &view.image.pixels[4 * pixel];
        rgba[0] = tile.red[i] + transmittance * background.x();
        rgba[1] = tile.green[i] + transmittance * background.y();
        rgba[2] = tile.blue[i] + transmittance * background.z();
        rgba[3] = 1.0f - transmittance;
        if (image_only_) continue;
        view.depth_m[pixel] = tile.depth_m[i];
        view.object_id[pixel] = rgba[3] < 0.5f ? kNoObject : largest_share(t, i);
      }
    }
  });
}

}  // namespace livegs

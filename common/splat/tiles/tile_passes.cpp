// SPDX-License-Identifier: Apache-2.0
// CPU functions of the passes of frame_tiles.h.
#include "splat/tiles/tile_passes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "splat/project/projected_kernel.h"
#include "splat/raster/ellipse_rim.h"
#include "tile_blend.spv.h"
#include "tile_pairs.spv.h"
#include "tile_ranges.spv.h"
#include "tile_scan.spv.h"

namespace livegs {
namespace {

static_assert(kTileEdge_px == kTileSize && kTileGroup == kTileSize * kTileSize);
constexpr float kMinTransmittance = 1e-4f;  // as in raster/tile_runs.h

SplatRow row_of(const PassArguments& arguments, uint32_t part_rows, uint32_t place) {
  return row_at<SplatRow>(arguments.buffers[place / part_rows], place % part_rows);
}

EllipseRim rim_of(const SplatRow& row, float rim) {
  ProjectedKernel kernel{};
  kernel.centre_x_px = row.centre_x_px;
  kernel.centre_y_px = row.centre_y_px;
  kernel.across_x = row.across_x;
  kernel.across_y = row.across_y;
  kernel.down_y = row.down_y;
  kernel.log2_opacity = row.log2_opacity;
  return {kernel, rim};
}

template <class Touch>
void for_each_tile(const SplatRow& row, float rim_value, const TileGrid& grid, const Touch& touch) {
  if (!(rim_value > 0.0f)) return;
  const EllipseRim rim = rim_of(row, rim_value);
  const TileSpan rows = rim.rows(grid);
  if (rows.first > rows.last) return;
  for (int r = rows.first / kTileSize; r <= rows.last / kTileSize; ++r) {
    const TileSpan span = rim.span(grid, r);
    for (int c = span.first; c <= span.last; ++c) touch(static_cast<uint32_t>(r * grid.columns() + c));
  }
}

// Twin of tile_pairs.comp.glsl. Ranges are whole groups.
void tile_pairs(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<TilePairsConstants>(arguments.constants, 0);
  const std::span<const uint32_t> order = words_of(arguments.buffers[3]);
  const auto drawn = row_at<SortedCount>(arguments.buffers[4], 0);
  const std::span<uint32_t> sums = words_of(arguments.buffers[5]);
  const std::span<uint32_t> tiles = words_of(arguments.buffers[6]);
  const std::span<uint32_t> places = words_of(arguments.buffers[7]);
  const TileGrid grid{static_cast<int>(constants.width_px), static_cast<int>(constants.height_px)};
  const auto first_tile = static_cast<uint32_t>(constants.eye * grid.size());
  LIVEGS_ASSERT(begin % kTileGroup == 0);
  for (size_t group = begin / kTileGroup; group * kTileGroup < end; ++group) {
    const size_t last = std::min<size_t>(drawn.instance_count, (group + 1) * kTileGroup);
    uint32_t& sum = sums[constants.eye * constants.block_capacity + group];
    uint64_t next = constants.pair_capacity == 0 ? 0 : sum;
    for (size_t i = group * kTileGroup; i < last; ++i) {
      const SplatRow row = row_of(arguments, constants.part_rows, order[i]);
      for_each_tile(row, row.log2_opacity - constants.log2_of_least_alpha, grid, [&](uint32_t tile) {
        if (next < constants.pair_capacity) {
          tiles[next] = first_tile + tile;
          places[next] = order[i];
        }
        ++next;
      });
    }
    if (constants.pair_capacity == 0) sum = static_cast<uint32_t>(next);
  }
}

// Twin of tile_scan.comp.glsl, which is a single group: the first range does all the work.
void tile_scan(const PassArguments& arguments, size_t begin, size_t) {
  if (begin != 0) return;
  const auto constants = row_at<TileScanConstants>(arguments.constants, 0);
  uint64_t next = 0;
  const auto saturated = [](uint64_t sum) {
    return static_cast<uint32_t>(std::min<uint64_t>(sum, std::numeric_limits<uint32_t>::max()));
  };
  for (uint32_t& sum : words_of(arguments.buffers[0]).first(constants.block_count)) {
    const uint32_t here = sum;
    sum = saturated(next);
    next += here;
  }
  set_row(arguments.buffers[1], 0, SortedCount{4, std::min(saturated(next), constants.pair_capacity), 0, 0});
  words_of(arguments.buffers[2])[0] = saturated(next);
}

// Twin of tile_ranges.comp.glsl.
void tile_ranges(const PassArguments& arguments, size_t begin, size_t end) {
  const auto pairs = row_at<SortedCount>(arguments.buffers[1], 0);
  const auto tiles = words_of(arguments.buffers[0]).first(pairs.instance_count);
  const std::span<uint32_t> firsts = words_of(arguments.buffers[2]);
  for (size_t tile = begin; tile < end; ++tile)
    firsts[tile] = static_cast<uint32_t>(std::lower_bound(tiles.begin(), tiles.end(), tile) - tiles.begin());
}

// One pixel of a tile.
struct Pixel {
  float red = 0, green = 0, blue = 0, transmittance = 1;
  bool finished = false;

  void blend(const SplatRow& row, float x, float y) {
    const float dx = x - row.centre_x_px, dy = y - row.centre_y_px;
    const float u = row.across_x * dx + row.across_y * dy, v = row.down_y * dy;
    const float alpha = std::min(kMaxAlpha, std::exp2(row.log2_opacity - v * v - u * u));
    if (alpha < kMinAlpha) return;
    const float weight = alpha * transmittance;
    if (transmittance - weight < kMinTransmittance) {
      finished = true;
      return;
    }
    red += weight * row.red;
    green += weight * row.green;
    blue += weight * row.blue;
    transmittance -= weight;
  }
};

uint32_t packed_rgba(const std::array<float, 4>& rgba) {
  uint32_t word = 0;
  for (int c = 0; c < 4; ++c)
    word |= static_cast<uint32_t>(std::lround(255.0f * std::clamp(rgba[c], 0.0f, 1.0f))) << (8 * c);
  return word;
}

// Twin of tile_blend.comp.glsl. Ranges are whole groups.
void tile_blend(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<TileBlendConstants>(arguments.constants, 0);
  const std::span<const uint32_t> places = words_of(arguments.buffers[3]);
  const std::span<const uint32_t> firsts = words_of(arguments.buffers[4]);
  const std::span<uint32_t> picture = words_of(arguments.buffers[5]);
  const TileGrid grid{static_cast<int>(constants.width_px), static_cast<int>(constants.height_px)};
  LIVEGS_ASSERT(begin % kTileGroup == 0);
  for (size_t tile = begin / kTileGroup; tile * kTileGroup < end; ++tile) {
    const int left = static_cast<int>(tile % grid.columns()) * kTileSize;
    const int top = static_cast<int>(tile / grid.columns()) * kTileSize;
    const int right = std::min(left + kTileSize, grid.width), bottom = std::min(top + kTileSize, grid.height);
    std::array<Pixel, kTileGroup> pixels;
    const size_t list = constants.eye * grid.size() + tile;
    size_t live = static_cast<size_t>(right - left) * (bottom - top);
    for (uint32_t i = firsts[list]; i < firsts[list + 1] && live > 0; ++i) {
      const SplatRow row = row_of(arguments, constants.part_rows, places[i]);
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
          Pixel& pixel = pixels[(y - top) * kTileSize + x - left];
          if (pixel.finished) continue;
          pixel.blend(row, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
          live -= pixel.finished ? 1 : 0;
        }
      }
    }
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const Pixel& p = pixels[(y - top) * kTileSize + x - left];
        const size_t place = (constants.eye * constants.height_px + y) * constants.width_px + x;
        const std::array floats{p.red, p.green, p.blue, 1.0f - p.transmittance};
        if (constants.floats != 0) {
          for (int c = 0; c < 4; ++c)
            set_row(arguments.buffers[5], kTileHeaderWords + 4 * place + c, floats[c]);
        } else {
          picture[kTileHeaderWords + place] = packed_rgba(
              {p.red + p.transmittance * constants.red, p.green + p.transmittance * constants.green,
               p.blue + p.transmittance * constants.blue, floats[3]});
        }
      }
    }
  }
}

Pass tile_pass(std::string_view name, uint32_t buffers, uint32_t constants_bytes,
               std::span<const uint32_t> spirv, void (*run)(const PassArguments&, size_t, size_t)) {
  return {.name = name,
          .group_size = kTileGroup,
          .buffer_count = buffers,
          .constants_bytes = constants_bytes,
          .spirv = spirv,
          .run = run};
}

}  // namespace

const Pass& tile_pairs_pass() {
  static const Pass pass =
      tile_pass("tile_pairs", 8, sizeof(TilePairsConstants), tile_pairs_spirv, tile_pairs);
  return pass;
}

const Pass& tile_scan_pass() {
  static const Pass pass = tile_pass("tile_scan", 3, sizeof(TileScanConstants), tile_scan_spirv, tile_scan);
  return pass;
}

const Pass& tile_ranges_pass() {
  static const Pass pass =
      tile_pass("tile_ranges", 3, sizeof(TileRangesConstants), tile_ranges_spirv, tile_ranges);
  return pass;
}

const Pass& tile_blend_pass() {
  static const Pass pass =
      tile_pass("tile_blend", 6, sizeof(TileBlendConstants), tile_blend_spirv, tile_blend);
  return pass;
}

}  // namespace livegs

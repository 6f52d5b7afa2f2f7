// SPDX-License-Identifier: Apache-2.0
// CPU functions of the passes of device_blender.h; the formulas are those of blend_tile.cpp.
#include "train/render/train_passes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/project/projected_kernel.h"
#include "splat/raster/bin_tiles.h"
#include "train_backward.spv.h"
#include "train_blend.spv.h"
#include "train_gather.spv.h"

namespace livegs {
namespace {

static_assert(kTrainGroup == kTileSize * kTileSize);

struct Step {
  float free_alpha, alpha, dx, dy;
};

Step step_of(const SplatRow& row, float x, float y) {
  const float dx = x - row.centre_x_px, dy = y - row.centre_y_px;
  const float u = row.across_x * dx + row.across_y * dy, v = row.down_y * dy;
  const float free_alpha = std::exp2(row.log2_opacity - v * v - u * u);
  return {free_alpha, std::min(kMaxAlpha, free_alpha), dx, dy};
}

// Pixels of a tile inside the picture.
struct TileArea {
  TileArea(const TileGrid& grid, size_t tile)
      : left(static_cast<int>(tile % grid.columns()) * kTileSize),
        top(static_cast<int>(tile / grid.columns()) * kTileSize),
        right(std::min(left + kTileSize, grid.width)),
        bottom(std::min(top + kTileSize, grid.height)) {}
  // visit(index in the tile, x, y)
  template <class Visit>
  void for_each_pixel(const Visit& visit) const {
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) visit((y - top) * kTileSize + x - left, x, y);
    }
  }
  int left, top, right, bottom;
};

// Inputs of both blending passes. Ranges start at whole groups.
struct TileLists {
  TileLists(const PassArguments& arguments, size_t begin)
      : constants(row_at<TrainBlendConstants>(arguments.constants, 0)),
        ranks(words_of(arguments.buffers[2])),
        pairs(words_of(arguments.buffers[3])),
        firsts(words_of(arguments.buffers[4])),
        grid{static_cast<int>(constants.width_px), static_cast<int>(constants.height_px)} {
    LIVEGS_ASSERT(begin % kTrainGroup == 0);
  }
  TrainBlendConstants constants;
  std::span<const uint32_t> ranks, pairs, firsts;
  TileGrid grid;
};

// Twin of train_blend.comp.glsl. Ranges are whole groups.
void train_blend(const PassArguments& arguments, size_t begin, size_t end) {
  const TileLists lists(arguments, begin);
  const TrainBlendConstants& constants = lists.constants;
  for (size_t tile = begin / kTrainGroup; tile * kTrainGroup < end; ++tile) {
    const TileArea area(lists.grid, tile);
    std::array<TrainPixel, kTrainGroup> pixels;
    std::array<bool, kTrainGroup> finished{};
    pixels.fill({kTrainNone, 0, 0, 0, 1, 0, 0, 0});
    for (uint32_t i = lists.firsts[tile]; i < lists.firsts[tile + 1]; ++i) {
      const uint32_t rank = lists.ranks[lists.pairs[i]];
      const auto row = row_at<SplatRow>(arguments.buffers[0], rank);
      const auto depth = row_at<float>(arguments.buffers[1], rank);
      area.for_each_pixel([&](int at, int x, int y) {
        TrainPixel& p = pixels[at];
        const Step s = step_of(row, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
        if (finished[at] || s.alpha < constants.min_alpha) return;
        const float weight = s.alpha * p.through, after = p.through - weight;
        if (after < constants.min_transmittance) {
          finished[at] = true;
          return;
        }
        p.red += weight * row.red;
        p.green += weight * row.green;
        p.blue += weight * row.blue;
        p.spread += 2 * weight * (depth * (1 - p.through) - p.depth_sum);
        p.depth_sum += weight * depth;
        if (p.through >= 0.5f && after < 0.5f) p.halfway = rank;
        p.through = after;
      });
    }
    area.for_each_pixel([&](int at, int x, int y) {
      set_row(arguments.buffers[5], size_t{1} + static_cast<size_t>(y) * constants.width_px + x, pixels[at]);
    });
  }
}

// A pixel on the way back.
struct Remainder {
  TrainPixelGradient by{};
  float left = 0, final_alpha = 0, final_depth = 0, through = 1, depth_sum = 0;
  bool finished = false;
};

// Adds the terms of one pixel to `sums`.
void add_terms(const SplatRow& row, float depth, int x, int y, const TrainBlendConstants& constants,
               Remainder& p, TrainEllipseGradient& sums) {
  const Step s = step_of(row, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  if (p.finished || s.alpha < constants.min_alpha) return;
  const float weight = s.alpha * p.through, after = p.through - weight;
  if (after < constants.min_transmittance) {
    p.finished = true;
    return;
  }
  float by_weight = p.by.red * row.red + p.by.green * row.green + p.by.blue * row.blue + p.by.alpha;
  if (p.by.spread != 0) {
    const float balance = 2 * (1 - p.through) - p.final_alpha;
    by_weight += 2 * p.by.spread * (depth * balance - (2 * p.depth_sum - p.final_depth));
    sums.depth += p.by.spread * 2 * weight * (balance + weight);
    p.depth_sum += weight * depth;
  }
  p.left -= weight * by_weight;
  const float g = s.free_alpha > kMaxAlpha ? 0 : weight * by_weight - s.alpha * p.left / (1 - s.alpha);
  sums.sum += g;
  sums.x += g * s.dx;
  sums.y += g * s.dy;
  sums.xx += g * s.dx * s.dx;
  sums.xy += g * s.dx * s.dy;
  sums.yy += g * s.dy * s.dy;
  sums.red += weight * p.by.red;
  sums.green += weight * p.by.green;
  sums.blue += weight * p.by.blue;
  p.through = after;
}

// Twin of train_backward.comp.glsl. Ranges are whole groups.
void train_backward(const PassArguments& arguments, size_t begin, size_t end) {
  const TileLists lists(arguments, begin);
  const TrainBlendConstants& constants = lists.constants;
  for (size_t tile = begin / kTrainGroup; tile * kTrainGroup < end; ++tile) {
    if (tile == lists.grid.size()) break;  // pairs of no tile; the twin of tile_pairs writes none
    const TileArea area(lists.grid, tile);
    std::array<Remainder, kTrainGroup> pixels;
    area.for_each_pixel([&](int at, int x, int y) {
      const size_t place = static_cast<size_t>(y) * constants.width_px + x;
      const auto seen = row_at<TrainPixel>(arguments.buffers[5], 1 + place);
      Remainder& p = pixels[at];
      p.by = row_at<TrainPixelGradient>(arguments.buffers[6], place);
      p.final_alpha = 1 - seen.through;
      p.final_depth = seen.depth_sum;
      p.left = p.by.red * (seen.red + seen.through * constants.red) +
               p.by.green * (seen.green + seen.through * constants.green) +
               p.by.blue * (seen.blue + seen.through * constants.blue) + p.by.alpha * p.final_alpha +
               2 * p.by.spread * seen.spread;
    });
    for (uint32_t i = lists.firsts[tile]; i < lists.firsts[tile + 1]; ++i) {
      const uint32_t rank = lists.ranks[lists.pairs[i]];
      const auto row = row_at<SplatRow>(arguments.buffers[0], rank);
      const auto depth = row_at<float>(arguments.buffers[1], rank);
      TrainEllipseGradient sums{};
      area.for_each_pixel(
          [&](int at, int x, int y) { add_terms(row, depth, x, y, constants, pixels[at], sums); });
      set_row(arguments.buffers[7], lists.pairs[i], sums);
    }
  }
}

// Twin of train_gather.comp.glsl.
void train_gather(const PassArguments& arguments, size_t begin, size_t end) {
  const std::span<const uint32_t> firsts = words_of(arguments.buffers[0]);
  constexpr size_t kNumbers = sizeof(TrainEllipseGradient) / sizeof(float);
  for (size_t rank = begin; rank < end; ++rank) {
    std::array<float, kNumbers> total{};
    for (uint32_t i = firsts[rank]; i < firsts[rank + 1]; ++i) {
      const auto one = row_at<std::array<float, kNumbers>>(arguments.buffers[1], i);
      for (size_t n = 0; n < kNumbers; ++n) total[n] += one[n];
    }
    set_row(arguments.buffers[2], rank, total);
  }
}

Pass train_pass(std::string_view name, uint32_t buffers, uint32_t constants_bytes,
                std::span<const uint32_t> spirv, void (*run)(const PassArguments&, size_t, size_t)) {
  return {.name = name,
          .group_size = kTrainGroup,
          .buffer_count = buffers,
          .constants_bytes = constants_bytes,
          .spirv = spirv,
          .run = run};
}

}  // namespace

const Pass& train_blend_pass() {
  static const Pass pass =
      train_pass("train_blend", 6, sizeof(TrainBlendConstants), train_blend_spirv, train_blend);
  return pass;
}

const Pass& train_backward_pass() {
  static const Pass pass =
      train_pass("train_backward", 8, sizeof(TrainBlendConstants), train_backward_spirv, train_backward);
  return pass;
}

const Pass& train_gather_pass() {
  static const Pass pass =
      train_pass("train_gather", 3, sizeof(TrainGatherConstants), train_gather_spirv, train_gather);
  return pass;
}

}  // namespace livegs

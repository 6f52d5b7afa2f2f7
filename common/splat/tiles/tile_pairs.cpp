// SPDX-License-Identifier: Apache-2.0
#include "splat/tiles/tile_pairs.h"

#include <algorithm>
#include <bit>
#include <string>

#include "core/assert.h"
#include "splat/raster/bin_tiles.h"
#include "splat/tiles/tile_passes.h"

namespace livegs {
namespace {

// Capacity for the first frame, and spare capacity for later ones. A frame with more pairs is binned twice.
constexpr uint32_t kFirstPairsPerKernel = 4;
constexpr double kSparePairs = 1.25;

// Groups of a dispatch that every Vulkan device runs.
constexpr uint32_t kMaxGroups = 65'535;

uint32_t blocks_of(uint32_t kernels) { return (kernels + kTileGroup - 1) / kTileGroup; }

}  // namespace

TilePairs::Kernels TilePairs::Kernels::of(const FrameSplats& frame) {
  Kernels kernels{.rows = {},
                  .order = frame.order(),
                  .drawn = frame.counted(),
                  .count = frame.kernel_count(),
                  .part_rows = frame.part_rows()};
  for (int eye = 0; eye < 2; ++eye) {
    for (int part = 0; part < FrameSplats::kRowParts; ++part) kernels.rows[eye][part] = frame.rows(eye, part);
  }
  return kernels;
}

TilePairs::TilePairs(Backend& backend, const Options& options) : backend_(&backend), options_(options) {
  const auto max_pairs = static_cast<uint32_t>(std::min<size_t>(
      {backend.max_buffer_bytes() / sizeof(uint32_t), KeySorter::kMaxKeys, size_t{kMaxGroups} * kSortTile}));
  options_.max_pairs = options.max_pairs > 0 ? std::min(options.max_pairs, max_pairs) : max_pairs;
}

std::array<BufferId, FrameSplats::kRowParts> TilePairs::rows_of(const Kernels& kernels, int eye) const {
  auto rows = kernels.rows[eye];
  for (int part = 1; part < FrameSplats::kRowParts; ++part) {
    if (rows[part] == rows[0]) rows[part] = no_rows_[part - 1].id();
  }
  return rows;
}

Result<void> TilePairs::make_sorter(uint64_t capacity) {
  sorter_.reset();
  places_.reset();
  const auto pairs = static_cast<uint32_t>(std::min<uint64_t>(capacity, options_.max_pairs));
  if (options_.keeps_unsorted) {
    if (auto made = places_.reserve(*backend_, sizeof(uint32_t) * pairs, "tiles"); !made) return made;
  }
  auto sorter = KeySorter::create(*backend_, pairs);
  if (!sorter) return Error{sorter.error().code, "tiles: " + sorter.error().message};
  sorter_.emplace(*std::move(sorter));
  return {};
}

Result<void> TilePairs::make_room(uint32_t kernels, size_t tiles, int eyes) {
  if (auto made = sums_.reserve(*backend_, sizeof(uint32_t) * eyes * blocks_of(kernels), "tiles"); !made)
    return made;
  if (auto made = firsts_.reserve(*backend_, sizeof(uint32_t) * (tiles + 1), "tiles"); !made) return made;
  for (Buffer& none : no_rows_) {
    if (auto made = none.reserve(*backend_, sizeof(SplatRow), "tiles"); !made) return made;
  }
  return sorter_ ? Result<void>{}
                 : make_sorter(uint64_t{kFirstPairsPerKernel} * eyes * std::max(kernels, kTileGroup));
}

Result<void> TilePairs::bin(const Kernels& kernels, int width, int height, int eyes, BufferId total) {
  LIVEGS_ASSERT(width > 0 && height > 0 && (eyes == 1 || eyes == 2));
  const uint32_t count = std::max(1u, kernels.count);
  if (TileGrid{width, height}.size() > kMaxGroups) {
    return invalid_argument("tiles: " + std::to_string(width) + "x" + std::to_string(height) +
                            " px exceed 65535 tiles of 16x16 px; draw a smaller picture");
  }
  const auto tiles = static_cast<uint32_t>(eyes * TileGrid{width, height}.size());
  if (auto made = make_room(count, tiles, eyes); !made) return made;
  TilePairsConstants pairs{.eye = 0,
                           .block_capacity = blocks_of(count),
                           .part_rows = kernels.part_rows,
                           .pair_capacity = 0,
                           .width_px = static_cast<uint32_t>(width),
                           .height_px = static_cast<uint32_t>(height),
                           .no_tile = tiles,
                           .log2_of_least_alpha = kernels.log2_of_least_alpha};
  const auto all_eyes = [&](uint32_t capacity) -> Result<void> {
    pairs.pair_capacity = capacity;
    for (int eye = 0; eye < eyes; ++eye) {
      pairs.eye = static_cast<uint32_t>(eye);
      const auto rows = rows_of(kernels, eye);
      const std::array buffers{rows[0],         rows[1],
                               rows[2],         kernels.order,
                               kernels.drawn,   sums_.id(),
                               sorter_->keys(), options_.keeps_unsorted ? places_.id() : sorter_->values()};
      if (auto done = backend_->dispatch(tile_pairs_pass(), buffers, std::as_bytes(std::span(&pairs, 1)),
                                         pairs.block_capacity * kTileGroup);
          !done)
        return done;
    }
    return {};
  };
  if (auto done = all_eyes(0); !done) return done;
  const TileScanConstants scan{eyes * pairs.block_capacity, sorter_->capacity()};
  const std::array scanned{sums_.id(), sorter_->counted(), total};
  if (auto done =
          backend_->dispatch(tile_scan_pass(), scanned, std::as_bytes(std::span(&scan, 1)), kTileGroup);
      !done)
    return done;
  if (auto done = all_eyes(sorter_->capacity()); !done) return done;
  if (auto done =
          sorter_->sort_counted(static_cast<uint32_t>(std::bit_width(tiles)), options_.keeps_unsorted);
      !done)
    return done;
  const TileRangesConstants ranges{tiles};
  const std::array ranged{sorter_->keys(), sorter_->counted(), firsts_.id()};
  return backend_->dispatch(tile_ranges_pass(), ranged, std::as_bytes(std::span(&ranges, 1)), tiles + 1);
}

Result<bool> TilePairs::fits(uint32_t pairs) {
  if (pairs <= sorter_->capacity()) return true;
  if (pairs > options_.max_pairs) {
    return Error{ErrorCode::TooLarge,
                 "tiles: " + std::to_string(pairs) + " pairs of tile and kernel exceed the limit of " +
                     std::to_string(options_.max_pairs) + "; draw fewer kernels or fewer pixels"};
  }
  if (auto made = make_sorter(static_cast<uint64_t>(kSparePairs * pairs)); !made) return made.error();
  return false;
}

}  // namespace livegs

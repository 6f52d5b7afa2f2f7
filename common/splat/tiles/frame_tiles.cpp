// SPDX-License-Identifier: Apache-2.0
#include "splat/tiles/frame_tiles.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "splat/project/projected_kernel.h"
#include "splat/raster/bin_tiles.h"
#include "splat/tiles/tile_passes.h"

namespace livegs {
namespace {

// Capacity of the first frame, and spare capacity of a later one. A frame with more is binned twice.
constexpr uint32_t kFirstPairsPerKernel = 4;
constexpr double kSparePairs = 1.25;

uint32_t blocks_of(uint32_t kernels) { return (kernels + kTileGroup - 1) / kTileGroup; }

}  // namespace

FrameTiles::FrameTiles(Backend& backend, const Options& options) : backend_(&backend), options_(options) {
  const auto most = static_cast<uint32_t>(
      std::min<size_t>(backend.max_buffer_bytes() / sizeof(uint32_t), KeySorter::kMaxKeys));
  options_.max_pairs = options.max_pairs > 0 ? std::min(options.max_pairs, most) : most;
}

size_t FrameTiles::picture_words() const {
  return kTileHeaderWords +
         (options_.floats ? size_t{4} : size_t{1}) * width_ * height_ * static_cast<size_t>(eyes_);
}

Result<void> FrameTiles::make_room(uint32_t kernels) {
  const auto make = [&](Buffer& buffer, size_t bytes) -> Result<void> {
    if (buffer.bytes() >= bytes) return {};
    buffer.reset();
    auto made = Buffer::create(*backend_, bytes);
    if (!made) return Error{made.error().code, "tiles: " + made.error().message};
    buffer = *std::move(made);
    return {};
  };
  const size_t tiles = eyes_ * TileGrid{width_, height_}.size();
  if (auto made = make(sums_, size_t{4} * eyes_ * blocks_of(kernels)); !made) return made;
  if (auto made = make(firsts_, 4 * (tiles + 1)); !made) return made;
  if (auto made = make(picture_, 4 * picture_words()); !made) return made;
  for (Buffer& none : no_rows_) {
    if (auto made = make(none, sizeof(SplatRow)); !made) return made;
  }
  if (sorter_) return {};
  auto sorter = KeySorter::create(
      *backend_,
      static_cast<uint32_t>(std::min<uint64_t>(
          uint64_t{kFirstPairsPerKernel} * eyes_ * std::max(kernels, kTileGroup), options_.max_pairs)));
  if (!sorter) return Error{sorter.error().code, "tiles: " + sorter.error().message};
  sorter_.emplace(*std::move(sorter));
  return {};
}

Result<void> FrameTiles::bin(const FrameSplats& frame, int width, int height, int eyes) {
  LIVEGS_ASSERT(width > 0 && height > 0 && (eyes == 1 || eyes == 2));
  width_ = width;
  height_ = height;
  eyes_ = eyes;
  const uint32_t kernels = std::max(1u, frame.kernel_count());
  if (auto made = make_room(kernels); !made) return made;
  const TileGrid grid{width, height};
  const auto tiles = static_cast<uint32_t>(eyes * grid.size());
  TilePairsConstants pairs{.eye = 0,
                           .block_capacity = blocks_of(kernels),
                           .part_rows = frame.part_rows(),
                           .pair_capacity = 0,
                           .width_px = static_cast<uint32_t>(width),
                           .height_px = static_cast<uint32_t>(height),
                           .no_tile = tiles};
  const auto both_eyes = [&](uint32_t capacity) -> Result<void> {
    pairs.pair_capacity = capacity;
    for (int eye = 0; eye < eyes; ++eye) {
      pairs.eye = static_cast<uint32_t>(eye);
      std::array buffers{frame.rows(eye, 0), frame.rows(eye, 1), frame.rows(eye, 2), frame.order(),
                         frame.counted(),    sums_.id(),         sorter_->keys(),    sorter_->values()};
      for (int part = 1; part < FrameSplats::kRowParts; ++part) {
        if (buffers[part] == buffers[0]) buffers[part] = no_rows_[part - 1].id();  // each binding differs
      }
      if (auto done = backend_->dispatch(tile_pairs_pass(), buffers, std::as_bytes(std::span(&pairs, 1)),
                                         pairs.block_capacity * kTileGroup);
          !done)
        return done;
    }
    return {};
  };
  if (auto done = both_eyes(0); !done) return done;
  const TileScanConstants scan{eyes * pairs.block_capacity, sorter_->capacity()};
  const std::array scanned{sums_.id(), sorter_->counted(), picture_.id()};
  if (auto done =
          backend_->dispatch(tile_scan_pass(), scanned, std::as_bytes(std::span(&scan, 1)), kTileGroup);
      !done)
    return done;
  if (auto done = both_eyes(sorter_->capacity()); !done) return done;
  if (auto done = sorter_->sort_counted(static_cast<uint32_t>(std::bit_width(tiles))); !done) return done;
  const TileRangesConstants ranges{tiles};
  const std::array ranged{sorter_->keys(), sorter_->counted(), firsts_.id()};
  return backend_->dispatch(tile_ranges_pass(), ranged, std::as_bytes(std::span(&ranges, 1)), tiles + 1);
}

Result<void> FrameTiles::blend(const FrameSplats& frame, const Eigen::Vector3f& background) {
  const TileGrid grid{width_, height_};
  for (int eye = 0; eye < eyes_; ++eye) {
    const TileBlendConstants constants{.eye = static_cast<uint32_t>(eye),
                                       .part_rows = frame.part_rows(),
                                       .width_px = static_cast<uint32_t>(width_),
                                       .height_px = static_cast<uint32_t>(height_),
                                       .red = background.x(),
                                       .green = background.y(),
                                       .blue = background.z(),
                                       .floats = options_.floats ? 1u : 0u};
    std::array buffers{frame.rows(eye, 0), frame.rows(eye, 1), frame.rows(eye, 2),
                       sorter_->values(),  firsts_.id(),       picture_.id()};
    for (int part = 1; part < FrameSplats::kRowParts; ++part) {
      if (buffers[part] == buffers[0]) buffers[part] = no_rows_[part - 1].id();
    }
    if (auto done = backend_->dispatch(tile_blend_pass(), buffers, std::as_bytes(std::span(&constants, 1)),
                                       static_cast<uint32_t>(grid.size()) * kTileGroup);
        !done)
      return done;
  }
  return {};
}

Result<bool> FrameTiles::fits(uint32_t pairs) {
  if (pairs <= sorter_->capacity()) return true;
  if (pairs > options_.max_pairs) {
    return Error{ErrorCode::TooLarge,
                 "tiles: " + std::to_string(pairs) + " pairs of tile and kernel; at most " +
                     std::to_string(options_.max_pairs) + "; draw fewer kernels or fewer pixels"};
  }
  sorter_.reset();
  auto sorter = KeySorter::create(
      *backend_,
      static_cast<uint32_t>(std::min<double>(kSparePairs * static_cast<double>(pairs), options_.max_pairs)));
  if (!sorter) return Error{sorter.error().code, "tiles: " + sorter.error().message};
  sorter_.emplace(*std::move(sorter));
  return false;
}

Result<bool> FrameTiles::finish() {
  uint32_t pairs = 0;
  if (auto done = backend_->read(picture_.id(), std::as_writable_bytes(std::span(&pairs, 1))); !done)
    return done.error();
  return fits(pairs);
}

Result<bool> FrameTiles::finish(std::vector<Image>& images) {
  std::vector<uint32_t> words(picture_words());
  if (auto done = backend_->read(picture_.id(), std::as_writable_bytes(std::span(words))); !done)
    return done.error();
  if (auto done = fits(words[0]); !done || !*done) return done;
  images.resize(static_cast<size_t>(eyes_));
  const size_t values = size_t{4} * width_ * height_;
  for (size_t e = 0; e < images.size(); ++e) {
    Image& image = images[e];
    image.width = width_;
    image.height = height_;
    image.pixels.resize(values);
    if (options_.floats) {
      std::memcpy(image.pixels.data(), words.data() + kTileHeaderWords + e * values, 4 * values);
      continue;
    }
    const uint32_t* packed = words.data() + kTileHeaderWords + e * (values / 4);
    parallel_for(values / 4, size_t{1} << 14, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        for (int c = 0; c < 4; ++c)
          image.pixels[4 * i + c] = static_cast<float>(packed[i] >> (8 * c) & 0xffu) / 255.0f;
      }
    });
  }
  return true;
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "splat/tiles/frame_tiles.h"

#include <array>
#include <cstring>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "splat/raster/bin_tiles.h"
#include "splat/tiles/tile_passes.h"

namespace livegs {

FrameTiles::FrameTiles(Backend& backend, const Options& options)
    : backend_(&backend), options_(options), pairs_(backend, {.max_pairs = options.max_pairs}) {}

size_t FrameTiles::picture_words() const {
  return kTileHeaderWords +
         (options_.floats ? size_t{4} : size_t{1}) * width_ * height_ * static_cast<size_t>(eyes_);
}

Result<void> FrameTiles::bin(const FrameSplats& frame, int width, int height, int eyes) {
  frame_ = &frame;
  width_ = width;
  height_ = height;
  eyes_ = eyes;
  if (auto made = picture_.reserve(*backend_, sizeof(uint32_t) * picture_words(), "tiles"); !made)
    return made;
  return pairs_.bin(TilePairs::Kernels::of(frame), width, height, eyes, picture_.id());
}

Result<void> FrameTiles::blend(const Eigen::Vector3f& background) {
  LIVEGS_ASSERT(frame_ != nullptr);
  background_ = background;
  const TilePairs::Kernels kernels = TilePairs::Kernels::of(*frame_);
  const TileGrid grid{width_, height_};
  for (int eye = 0; eye < eyes_; ++eye) {
    const TileBlendConstants constants{.eye = static_cast<uint32_t>(eye),
                                       .part_rows = kernels.part_rows,
                                       .width_px = static_cast<uint32_t>(width_),
                                       .height_px = static_cast<uint32_t>(height_),
                                       .red = background.x(),
                                       .green = background.y(),
                                       .blue = background.z(),
                                       .floats = options_.floats ? 1u : 0u};
    const auto rows = pairs_.rows_of(kernels, eye);
    const std::array buffers{rows[0], rows[1], rows[2], pairs_.values(), pairs_.firsts(), picture_.id()};
    if (auto done = backend_->dispatch(tile_blend_pass(), buffers, std::as_bytes(std::span(&constants, 1)),
                                       static_cast<uint32_t>(grid.size()) * kTileGroup);
        !done)
      return done;
  }
  return {};
}

Result<void> FrameTiles::read_complete(std::span<uint32_t> words) {
  for (;;) {
    if (auto done = backend_->read(picture_.id(), std::as_writable_bytes(words)); !done) return done;
    auto fits = pairs_.fits(words[0]);
    if (!fits) return fits.error();
    if (*fits) return {};
    if (auto done = bin(*frame_, width_, height_, eyes_); !done) return done;
    if (auto done = blend(background_); !done) return done;
  }
}

Result<void> FrameTiles::finish() {
  uint32_t header = 0;
  return read_complete({&header, 1});
}

Result<void> FrameTiles::finish(std::vector<Image>& images) {
  std::vector<uint32_t> words(picture_words());
  if (auto done = read_complete(words); !done) return done;
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
  return {};
}

}  // namespace livegs

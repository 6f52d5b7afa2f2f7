// SPDX-License-Identifier: Apache-2.0
#include "train/render/device_blender.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "splat/raster/bin_tiles.h"
#include "splat/tiles/tile_passes.h"
#include "train/render/train_passes.h"

namespace livegs {
namespace {

static_assert(sizeof(EllipseGradient) == sizeof(TrainEllipseGradient));
constexpr size_t kSpareShare = 4;  // a buffer grows by a quarter more than is needed

template <class Row>
std::span<const std::byte> bytes_of(const std::vector<Row>& rows) {
  return std::as_bytes(std::span(rows));
}

}  // namespace

DeviceBlender::DeviceBlender(std::unique_ptr<Backend> backend)
    : backend_(std::move(backend)), pairs_(*backend_, {.keeps_unsorted = true}) {}

Result<void> DeviceBlender::make_room() {
  const size_t kernels = std::max(1u, count_), pixels = static_cast<size_t>(width_) * height_;
  const std::pair<Buffer*, size_t> wanted[] = {{&rows_, kernels * sizeof(SplatRow)},
                                               {&depths_, kernels * sizeof(float)},
                                               {&order_, kernels * sizeof(uint32_t)},
                                               {&drawn_, sizeof(SortedCount)},
                                               {&picture_buffer_, (pixels + 1) * sizeof(TrainPixel)},
                                               {&by_picture_, pixels * sizeof(TrainPixelGradient)},
                                               {&kernel_firsts_, (kernels + 1) * sizeof(uint32_t)},
                                               {&kernel_gradients_, kernels * sizeof(TrainEllipseGradient)}};
  for (const auto& [buffer, bytes] : wanted) {
    const size_t roomy = buffer->bytes() >= bytes ? bytes : (bytes + bytes / kSpareShare + 3) / 4 * 4;
    if (auto made = buffer->reserve(*backend_, roomy, "training"); !made) return made;
  }
  return {};
}

Result<void> DeviceBlender::upload_kernels(std::span<const ProjectedKernel> kernels) {
  row_memory_.resize(kernels.size());
  depth_memory_.resize(kernels.size());
  parallel_for(kernels.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const ProjectedKernel& from = kernels[k];
      row_memory_[k] = {from.centre_x_px,  from.centre_y_px, from.across_x, from.across_y, from.down_y,
                        from.log2_opacity, from.red,         from.green,    from.blue};
      depth_memory_[k] = from.depth_m;
    }
  });
  if (const auto capacity = static_cast<uint32_t>(order_.bytes() / sizeof(uint32_t));
      order_count_ != capacity) {
    std::vector<uint32_t> order(capacity);
    std::iota(order.begin(), order.end(), 0u);
    if (auto done = backend_->upload(order_.id(), bytes_of(order)); !done) return done;
    order_count_ = capacity;
  }
  const SortedCount drawn{4, count_, 0, 0};
  if (auto done = backend_->upload(drawn_.id(), std::as_bytes(std::span(&drawn, 1))); !done) return done;
  if (kernels.empty()) return {};
  if (auto done = backend_->upload(rows_.id(), bytes_of(row_memory_)); !done) return done;
  return backend_->upload(depths_.id(), bytes_of(depth_memory_));
}

Result<void> DeviceBlender::forward(std::span<const ProjectedKernel> kernels, int width, int height,
                                    const RenderCuts& cuts) {
  width_ = width;
  height_ = height;
  cuts_ = cuts;
  count_ = static_cast<uint32_t>(kernels.size());
  if (auto made = make_room(); !made) return made;
  if (auto done = upload_kernels(kernels); !done) return done;
  const TilePairs::Kernels drawn{.rows = {{{rows_.id(), rows_.id(), rows_.id()}, {}}},
                                 .order = order_.id(),
                                 .drawn = drawn_.id(),
                                 .count = count_,
                                 .part_rows = std::max(1u, count_),
                                 .log2_of_least_alpha = std::log2(cuts.min_alpha)};
  const TrainBlendConstants constants{.width_px = static_cast<uint32_t>(width),
                                      .height_px = static_cast<uint32_t>(height),
                                      .min_alpha = cuts.min_alpha,
                                      .min_transmittance = cuts.min_transmittance,
                                      .log2_of_least_alpha = drawn.log2_of_least_alpha,
                                      .red = 0,
                                      .green = 0,
                                      .blue = 0};
  const auto tiles = static_cast<uint32_t>(TileGrid{width, height}.size());
  picture_.resize(1 + static_cast<size_t>(width) * height);
  for (;;) {
    if (auto done = pairs_.bin(drawn, width, height, 1, picture_buffer_.id()); !done) return done;
    const std::array buffers{rows_.id(),      depths_.id(),    pairs_.places(),
                             pairs_.values(), pairs_.firsts(), picture_buffer_.id()};
    if (auto done = backend_->dispatch(train_blend_pass(), buffers, std::as_bytes(std::span(&constants, 1)),
                                       tiles * kTrainGroup);
        !done)
      return done;
    if (auto done = backend_->read(picture_buffer_.id(), std::as_writable_bytes(std::span(picture_))); !done)
      return done;
    uint32_t pairs = 0;
    std::memcpy(&pairs, picture_.data(), sizeof pairs);
    auto fits = pairs_.fits(pairs);
    if (!fits) return fits.error();
    if (*fits) return {};
  }
}

Result<void> DeviceBlender::backward(std::span<const TrainPixelGradient> by_picture,
                                     const Eigen::Vector3f& background,
                                     std::vector<EllipseGradient>& by_kernel) {
  LIVEGS_ASSERT(by_picture.size() + 1 == picture_.size());
  by_kernel.resize(count_);
  if (count_ == 0) return {};
  if (auto made =
          pair_gradients_.reserve(*backend_, sizeof(TrainEllipseGradient) * pairs_.capacity(), "training");
      !made)
    return made;
  if (auto done = backend_->upload(by_picture_.id(), std::as_bytes(by_picture)); !done) return done;
  const TrainBlendConstants constants{.width_px = static_cast<uint32_t>(width_),
                                      .height_px = static_cast<uint32_t>(height_),
                                      .min_alpha = cuts_.min_alpha,
                                      .min_transmittance = cuts_.min_transmittance,
                                      .log2_of_least_alpha = std::log2(cuts_.min_alpha),
                                      .red = background.x(),
                                      .green = background.y(),
                                      .blue = background.z()};
  const auto tiles = static_cast<uint32_t>(TileGrid{width_, height_}.size());
  const std::array buffers{rows_.id(),      depths_.id(),         pairs_.places(),  pairs_.values(),
                           pairs_.firsts(), picture_buffer_.id(), by_picture_.id(), pair_gradients_.id()};
  if (auto done = backend_->dispatch(train_backward_pass(), buffers, std::as_bytes(std::span(&constants, 1)),
                                     (tiles + 1) * kTrainGroup);
      !done)
    return done;
  const TileRangesConstants ranges{count_};
  const std::array ranged{pairs_.places(), pairs_.counted(), kernel_firsts_.id()};
  if (auto done =
          backend_->dispatch(tile_ranges_pass(), ranged, std::as_bytes(std::span(&ranges, 1)), count_ + 1);
      !done)
    return done;
  const TrainGatherConstants gather{count_};
  const std::array gathered{kernel_firsts_.id(), pair_gradients_.id(), kernel_gradients_.id()};
  if (auto done =
          backend_->dispatch(train_gather_pass(), gathered, std::as_bytes(std::span(&gather, 1)), count_);
      !done)
    return done;
  return backend_->read(kernel_gradients_.id(), std::as_writable_bytes(std::span(by_kernel)));
}

}  // namespace livegs

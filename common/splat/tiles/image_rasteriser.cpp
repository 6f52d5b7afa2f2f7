// SPDX-License-Identifier: Apache-2.0
#include "splat/tiles/image_rasteriser.h"

#include <array>
#include <utility>
#include <vector>

#include "core/log.h"
#include "core/parallel_for.h"
#include "splat/passes/device_kernels.h"

namespace livegs {
namespace {

constexpr size_t kPixelBlock = size_t{1} << 14;

}  // namespace

struct ImageRasteriser::Device {
  explicit Device(std::unique_ptr<Backend> one)
      : backend(std::move(one)), frame(*backend), tiles(*backend, {.floats = true}) {}

  // Identifies the content of an asset by its place in memory and a sample of its kernels. Assets do not
  // change while they are drawn; another asset at the same place differs in the sample.
  struct AssetMark {
    explicit AssetMark(const GaussianAsset& asset) : memory(asset.positions.data()), kernels(asset.size()) {
      const size_t step = kernels / kSamples + 1;
      for (size_t k = 0, i = 0; k < kernels; k += step, ++i) {
        sample[i] = {asset.positions[k].x(), asset.positions[k].y(), asset.positions[k].z(),
                     asset.sh_dc[k].x(), asset.opacity_logits[k]};
      }
    }
    bool operator==(const AssetMark&) const = default;

    static constexpr size_t kSamples = 64;
    const void* memory;
    size_t kernels;
    std::array<std::array<float, 5>, kSamples> sample{};
  };
  struct Held {
    AssetMark mark;
    DeviceKernels kernels;
  };
  std::unique_ptr<Backend> backend;  // outlives the rest
  std::map<uint32_t, Held> held;     // by object id
  FrameSplats frame;
  FrameTiles tiles;
  std::vector<Image> images;
};

ImageRasteriser::ImageRasteriser(std::unique_ptr<Backend> device)
    : device_(device ? std::make_unique<Device>(std::move(device)) : nullptr) {}
ImageRasteriser::~ImageRasteriser() = default;

void ImageRasteriser::draw(std::span<const DrawnObject> objects, const Camera& camera,
                           const RasteriseOptions& options, Image& image) {
  if (device_) {
    const auto done = draw_on_device(objects, camera, options, image);
    if (done) return;
    const bool lost =
        done.error().code != ErrorCode::TooLarge && done.error().code != ErrorCode::InvalidArgument;
    log_warn("pictures: the CPU draws %s (%s)", lost ? "from now on" : "this one",
             done.error().message.c_str());
    if (lost) device_.reset();
  }
  RasteriseOptions image_only = options;
  image_only.image_only = true;
  rasteriser_.draw(objects, camera, image_only, view_);
  visible_kernels_ = rasteriser_.last_times().visible_kernels;
  image = view_.image;
}

Result<void> ImageRasteriser::draw_on_device(std::span<const DrawnObject> objects, const Camera& camera,
                                             const RasteriseOptions& options, Image& image) {
  Device& d = *device_;
  std::map<uint32_t, Device::Held> drawn;
  for (const DrawnObject& object : objects) {
    const Device::AssetMark mark(*object.asset);
    if (const auto found = d.held.find(object.object_id);
        found != d.held.end() && found->second.mark == mark) {
      drawn.insert(d.held.extract(found));
      continue;
    }
    auto kernels = DeviceKernels::create(*d.backend, *object.asset);
    if (!kernels) return kernels.error();
    drawn.emplace(object.object_id, Device::Held{mark, *std::move(kernels)});
  }
  d.held = std::move(drawn);
  std::vector<FrameSplats::Object> in_frame;
  for (const DrawnObject& object : objects) {
    DeviceKernels& kernels = d.held.at(object.object_id).kernels;
    if (auto done = kernels.pose(*object.kernels); !done) return done;
    in_frame.push_back({&kernels, {}, object.object_id});
  }
  const FrameSplats::Options splats{.order = options.order,
                                    .max_sh_degree = options.max_sh_degree,
                                    .max_radius_px = options.max_radius_px,
                                    .min_contribution_px = options.min_contribution_px,
                                    .shadows = options.shadows,
                                    .environments = options.environments};
  if (auto done = d.frame.project(in_frame, {&camera, 1}, splats); !done) return done;
  if (auto done = d.frame.sort(); !done) return done;
  if (auto done = d.tiles.bin(d.frame, camera.width, camera.height, 1); !done) return done;
  if (auto done = d.tiles.blend(options.background); !done) return done;
  if (auto done = d.tiles.finish(d.images); !done) return done;
  SortedCount counted;
  if (auto done = d.backend->read(d.frame.counted(), std::as_writable_bytes(std::span(&counted, 1))); !done)
    return done;
  visible_kernels_ = counted.instance_count;
  image = std::move(d.images[0]);
  parallel_for(image.pixels.size() / 4, kPixelBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      float* rgba = &image.pixels[4 * i];
      for (int c = 0; c < 3; ++c) rgba[c] += (1.0f - rgba[3]) * options.background[c];
    }
  });
  return {};
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "splat/rasterise.h"

#include <algorithm>

#include "core/assert.h"
#include "core/clock.h"
#include "splat/raster/blend_tiles.h"
#include "splat/raster/sorted_kernels.h"

namespace livegs {
namespace {

// Objects with the same id share a slot. Slots are in order of first appearance.
struct ObjectSlots {
  std::vector<uint32_t> ids;
  std::vector<uint32_t> slot_of_object;

  explicit ObjectSlots(std::span<const DrawnObject> objects) {
    for (const DrawnObject& object : objects) {
      const auto found = std::find(ids.begin(), ids.end(), object.object_id);
      slot_of_object.push_back(static_cast<uint32_t>(found - ids.begin()));
      if (found == ids.end()) ids.push_back(object.object_id);
    }
  }
};

}  // namespace

struct Rasteriser::Buffers {
  SortedKernels sorted;
  TileBlender blender;
  Times times;

  void blend(const TileGrid& grid);
};

void Rasteriser::Buffers::blend(const TileGrid& grid) {
  int64_t last_ns = now_ns();
  const auto blend_batch = [&](std::span<const ProjectedKernel> kernels, const TileBins& bins) {
    const int64_t binned_ns = now_ns();
    blender.blend(kernels, bins);
    const int64_t blended_ns = now_ns();
    times.sort_ms += milliseconds_from_ns(binned_ns - last_ns);
    times.blend_ms += milliseconds_from_ns(blended_ns - binned_ns);
    last_ns = blended_ns;
  };
  sorted.for_each_batch(
      grid, [&] { return blender.live(); }, blend_batch);
}

Rasteriser::Rasteriser() : buffers_(std::make_unique<Buffers>()) {}
Rasteriser::~Rasteriser() = default;
Rasteriser::Rasteriser(Rasteriser&&) noexcept = default;
Rasteriser& Rasteriser::operator=(Rasteriser&&) noexcept = default;

const Rasteriser::Times& Rasteriser::last_times() const { return buffers_->times; }

void Rasteriser::draw(std::span<const DrawnObject> objects, const Camera& camera,
                      const RasteriseOptions& options, RasterisedView& view) {
  LIVEGS_ASSERT(camera.width > 0 && camera.height > 0);
  const size_t pixels = static_cast<size_t>(camera.width) * camera.height;
  view.image.width = camera.width;
  view.image.height = camera.height;
  view.image.pixels.resize(4 * pixels);
  view.depth_m.resize(options.image_only ? 0 : pixels);
  view.object_id.resize(options.image_only ? 0 : pixels);

  Buffers& b = *buffers_;
  b.times = {};
  const ObjectSlots slots(objects);
  const TileGrid grid{camera.width, camera.height};

  const int64_t start_ns = now_ns();
  b.sorted.project(objects, slots.slot_of_object, camera, options);
  const int64_t projected_ns = now_ns();
  b.sorted.sort();
  const int64_t sorted_ns = now_ns();
  b.times.visible_kernels = b.sorted.visible_count();
  b.times.project_ms = milliseconds_from_ns(projected_ns - start_ns);
  b.times.sort_ms = milliseconds_from_ns(sorted_ns - projected_ns);
  b.blender.begin(grid, slots.ids.size(), options.image_only);
  b.times.blend_ms = milliseconds_from_ns(now_ns() - sorted_ns);
  b.blend(grid);
  const int64_t blended_ns = now_ns();
  b.blender.resolve(options.background, slots.ids, view);
  b.times.blend_ms += milliseconds_from_ns(now_ns() - blended_ns);
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "splat/rasterise.h"

#include <algorithm>
#include <numeric>

#include "core/assert.h"
#include "core/clock.h"
#include "core/parallel_for.h"
#include "splat/passes/radix_sort.h"
#include "splat/project/project_kernels.h"
#include "splat/raster/bin_tiles.h"
#include "splat/raster/blend_tiles.h"

namespace livegs {
namespace {

constexpr size_t kProjectBlock = 1024;  // kernels
constexpr size_t kRasterPrefetch = 16;  // prefetch distance in kernels

// Kernels are binned and blended in batches, nearest first, so that opaque tiles receive no more kernels and
// the bins stay bounded for a camera inside an object. A batch consists of whole groups; their bounding boxes
// cover about this number of tiles.
constexpr size_t kGroup = 1024;  // kernels
constexpr size_t kBatchTiles = size_t{1} << 20;

// The kernels of all objects in one sequence: object o starts at first[o].
struct KernelRange {
  std::vector<size_t> first;
  size_t total = 0;

  explicit KernelRange(std::span<const DrawnObject> objects) {
    for (const DrawnObject& object : objects) {
      LIVEGS_ASSERT(object.asset && object.kernels);
      const size_t count = object.asset->size();
      LIVEGS_ASSERT(object.kernels->positions_m.size() == count);
      LIVEGS_ASSERT(object.kernels->covariances_m2.size() == count);
      LIVEGS_ASSERT(object.kernels->world_from_asset.size() == count);
      first.push_back(total);
      total += count;
    }
  }

  // Index of the object that contains kernel i.
  size_t object_of(size_t i) const {
    return static_cast<size_t>(std::upper_bound(first.begin(), first.end(), i) - first.begin()) - 1;
  }
};

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
  std::vector<ProjectedKernel> projected;            // block by block, each compacted to its front
  std::vector<uint32_t> block_counts, block_begins;  // kernels of each block, and of all blocks before it
  std::vector<float> order_depths_m;
  std::vector<KeyedIndex> keys, key_scratch;
  std::vector<uint32_t> order;
  std::vector<size_t> group_tiles;
  TileBins bins;
  TileBlender blender;
  Times times;

  void project(std::span<const DrawnObject> objects, const ObjectSlots& slots, const Camera& camera,
               const RasteriseOptions& options);
  void sort();
  void blend(const TileGrid& grid);
};

void Rasteriser::Buffers::project(std::span<const DrawnObject> objects, const ObjectSlots& slots,
                                  const Camera& camera, const RasteriseOptions& options) {
  const KernelRange range(objects);
  const Projection projection(camera);
  const size_t blocks = (range.total + kProjectBlock - 1) / kProjectBlock;
  // Never shrunk: entries beyond the counts are stale.
  if (projected.size() < range.total) {
    projected.resize(range.total);
    order_depths_m.resize(range.total);
  }
  block_counts.assign(blocks, 0);
  parallel_for(range.total, kProjectBlock, [&](size_t begin, size_t end) {
    size_t next = begin;
    size_t object = range.object_of(begin);
    for (size_t i = begin; i < end; ++i) {
      while (object + 1 < objects.size() && i >= range.first[object + 1]) ++object;
      next += project_kernel(projection, objects[object], i - range.first[object],
                             slots.slot_of_object[object], options, projected[next], order_depths_m[next]);
    }
    block_counts[begin / kProjectBlock] = static_cast<uint32_t>(next - begin);
  });
  block_begins.resize(blocks);
  std::exclusive_scan(block_counts.begin(), block_counts.end(), block_begins.begin(), 0u);
  keys.resize(blocks == 0 ? 0 : block_begins.back() + block_counts.back());
  parallel_for(range.total, kProjectBlock, [&](size_t begin, size_t) {
    const size_t block = begin / kProjectBlock;
    KeyedIndex* next = keys.data() + block_begins[block];
    for (size_t i = begin; i < begin + block_counts[block]; ++i)
      *next++ = {ordered_key(order_depths_m[i]), static_cast<uint32_t>(i)};
  });
  times.visible_kernels = keys.size();
}

void Rasteriser::Buffers::sort() {
  radix_sort(keys, key_scratch);
  order.resize(keys.size());
  group_tiles.assign((keys.size() + kGroup - 1) / kGroup, 0);
  parallel_for(keys.size(), kGroup, [&](size_t begin, size_t end) {
    size_t tiles = 0;
    for (size_t i = begin; i < end; ++i) {
      if (i + kRasterPrefetch < end) __builtin_prefetch(&projected[keys[i + kRasterPrefetch].index]);
      order[i] = keys[i].index;
      tiles += projected[order[i]].tile_bound;
    }
    group_tiles[begin / kGroup] = tiles;
  });
}

void Rasteriser::Buffers::blend(const TileGrid& grid) {
  const std::span<const uint32_t> all(order);
  for (size_t group = 0; group < group_tiles.size();) {
    const size_t begin = group * kGroup;
    size_t tiles = 0;
    do {
      tiles += group_tiles[group++];
    } while (group < group_tiles.size() && tiles < kBatchTiles);
    const size_t end = std::min(all.size(), group * kGroup);
    const int64_t start_ns = now_ns();
    bins.fill(projected, all.subspan(begin, end - begin), grid, blender.live());
    const int64_t binned_ns = now_ns();
    blender.blend(projected, bins);
    times.sort_ms += milliseconds_from_ns(binned_ns - start_ns);
    times.blend_ms += milliseconds_from_ns(now_ns() - binned_ns);
  }
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
  b.project(objects, slots, camera, options);
  const int64_t projected_ns = now_ns();
  b.sort();
  const int64_t sorted_ns = now_ns();
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

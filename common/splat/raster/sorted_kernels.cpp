// SPDX-License-Identifier: Apache-2.0
#include "splat/raster/sorted_kernels.h"

#include <numeric>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "splat/passes/key_order.h"

namespace livegs {
namespace {

constexpr size_t kProjectBlock = 1024;  // kernels
constexpr size_t kRasterPrefetch = 16;  // prefetch distance in kernels

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

}  // namespace

void SortedKernels::project(std::span<const DrawnObject> objects, std::span<const uint32_t> slot_of_object,
                            const Camera& camera, const RasteriseOptions& options) {
  const KernelRange range(objects);
  const Projection projection(camera);
  const size_t blocks = (range.total + kProjectBlock - 1) / kProjectBlock;
  // Never shrunk: entries beyond the counts are stale.
  if (projected_.size() < range.total) {
    projected_.resize(range.total);
    order_depths_m_.resize(range.total);
  }
  block_counts_.assign(blocks, 0);
  parallel_for(range.total, kProjectBlock, [&](size_t begin, size_t end) {
    size_t next = begin;
    size_t object = range.object_of(begin);
    for (size_t i = begin; i < end; ++i) {
      while (object + 1 < objects.size() && i >= range.first[object + 1]) ++object;
      next += project_kernel(projection, objects[object], i - range.first[object], slot_of_object[object],
                             options, projected_[next], order_depths_m_[next]);
    }
    block_counts_[begin / kProjectBlock] = static_cast<uint32_t>(next - begin);
  });
  block_begins_.resize(blocks);
  std::exclusive_scan(block_counts_.begin(), block_counts_.end(), block_begins_.begin(), 0u);
  keys_.resize(blocks == 0 ? 0 : block_begins_.back() + block_counts_.back());
  parallel_for(range.total, kProjectBlock, [&](size_t begin, size_t) {
    const size_t block = begin / kProjectBlock;
    KeyedIndex* next = keys_.data() + block_begins_[block];
    for (size_t i = begin; i < begin + block_counts_[block]; ++i)
      *next++ = {ordered_key(order_depths_m_[i]), static_cast<uint32_t>(i)};
  });
}

void SortedKernels::sort() {
  radix_sort(keys_, key_scratch_);
  order_.resize(keys_.size());
  group_tiles_.assign((keys_.size() + kGroup - 1) / kGroup, 0);
  parallel_for(keys_.size(), kGroup, [&](size_t begin, size_t end) {
    size_t tiles = 0;
    for (size_t i = begin; i < end; ++i) {
      if (i + kRasterPrefetch < end) __builtin_prefetch(&projected_[keys_[i + kRasterPrefetch].index]);
      order_[i] = keys_[i].index;
      tiles += projected_[order_[i]].tile_bound;
    }
    group_tiles_[begin / kGroup] = tiles;
  });
}

}  // namespace livegs

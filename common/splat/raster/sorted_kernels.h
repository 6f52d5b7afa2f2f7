// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "splat/camera.h"
#include "splat/project/project_kernels.h"
#include "splat/raster/bin_tiles.h"
#include "splat/raster/radix_sort.h"

namespace livegs {

// The visible kernels of one view in drawing order, shared by the passes of the CPU that blend them. Buffers
// are kept between calls. Deterministic for any thread count.
class SortedKernels {
 public:
  // Projects the kernels of all objects; the kernels of object o get slot_of_object[o].
  void project(std::span<const DrawnObject> objects, std::span<const uint32_t> slot_of_object,
               const Camera& camera, const RasteriseOptions& options);
  // Sorts nearest first. Call after project().
  void sort();

  size_t visible_count() const { return keys_.size(); }

  // Bins the sorted kernels batch by batch, nearest first. `live` returns one word per tile; tiles with a 0
  // get no kernels. `blend(kernels, bins)` blends a batch.
  template <class Live, class Blend>
  void for_each_batch(const TileGrid& grid, Live&& live, Blend&& blend) {
    const std::span<const uint32_t> all(order_);
    for (size_t group = 0; group < group_tiles_.size();) {
      const size_t begin = group * kGroup;
      size_t tiles = 0;
      do {
        tiles += group_tiles_[group++];
      } while (group < group_tiles_.size() && tiles < kBatchTiles);
      const size_t end = std::min(all.size(), group * kGroup);
      bins_.fill(projected_, all.subspan(begin, end - begin), grid, live());
      blend(std::span<const ProjectedKernel>(projected_), bins_);
    }
  }

 private:
  // Kernels are binned and blended in batches, nearest first, so that opaque tiles receive no more kernels
  // and the bins stay bounded for a camera inside an object. A batch consists of whole groups; their bounding
  // boxes cover about this number of tiles.
  static constexpr size_t kGroup = 1024;  // kernels
  static constexpr size_t kBatchTiles = size_t{1} << 20;

  std::vector<ProjectedKernel> projected_;             // block by block, each compacted to its front
  std::vector<uint32_t> block_counts_, block_begins_;  // kernels of each block, and of all blocks before it
  std::vector<float> order_depths_m_;
  std::vector<KeyedIndex> keys_, key_scratch_;
  std::vector<uint32_t> order_;
  std::vector<size_t> group_tiles_;
  TileBins bins_;
};

}  // namespace livegs

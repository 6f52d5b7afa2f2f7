// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "compute/buffer.h"
#include "splat/passes/key_sorter.h"
#include "splat/project/projected_kernel.h"
#include "splat/raster/frame_splats.h"

namespace livegs {

// The kernels that touch each tile of 16 x 16 pixels, nearest first: pairs of tile and kernel, sorted by
// tile. Takes 16 bytes per pair; a kernel of 10 pixels' radius touches about five tiles. One thread.
class TilePairs {
 public:
  // Kernels in draw order, on the backend of the pairs.
  struct Kernels {
    std::array<std::array<BufferId, FrameSplats::kRowParts>, 2>
        rows;               // by eye; missing parts repeat the first
    BufferId order, drawn;  // row of each kernel; SortedCount
    uint32_t count = 0;     // at least that of `drawn`
    uint32_t part_rows = 0;
    float log2_of_least_alpha = -kLog2Of255;  // kernels end where their alpha falls below it

    static Kernels of(const FrameSplats& frame);
  };
  struct Options {
    uint32_t max_pairs = 0;       // 0: the limit of the device
    bool keeps_unsorted = false;  // values() are indices of places(), which keep the order of the kernels
  };
  TilePairs(Backend& backend, const Options& options);

  // Records the passes. `total`: its first word receives the number of pairs, which may exceed the capacity.
  // Eyes of equal size in px, at most 2; tiles of the second eye follow those of the first.
  // InvalidArgument for pictures of more than 65 535 tiles.
  Result<void> bin(const Kernels& kernels, int width, int height, int eyes, BufferId total);

  // After the passes have run: false if the frame had more pairs than the buffers hold. They have grown, bin
  // again. TooLarge if the device holds no buffers for them.
  Result<bool> fits(uint32_t pairs);

  BufferId values() const {
    return sorter_->values();
  }                                                 // by pair, in the order of the tiles: row of the kernel
  BufferId firsts() const { return firsts_.id(); }  // by tile: its first pair; one more at the end
  BufferId places() const { return places_.id(); }  // by pair, in the order of the kernels: row
  BufferId counted() const { return sorter_->counted(); }  // SortedCount of the pairs
  uint32_t capacity() const { return sorter_->capacity(); }
  // Rows of one eye as three different buffers, as passes need them.
  std::array<BufferId, FrameSplats::kRowParts> rows_of(const Kernels& kernels, int eye) const;

 private:
  Result<void> make_room(uint32_t kernels, size_t tiles, int eyes);
  Result<void> make_sorter(uint64_t capacity);

  Backend* backend_;
  Options options_;
  std::optional<KeySorter> sorter_;  // keys are tiles
  Buffer sums_, firsts_, places_, no_rows_[2];
};

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "compute/buffer.h"
#include "splat/passes/sort_keys_layout.h"

namespace livegs {

// Sorts kernels by depth on a backend, nearest first: 32-bit keys with 32-bit values, ascending and stable.
// The pass project_splats writes the keys (project_splats.h), floats by ordered_key (key_order.h).
// FrameSplats::sort calls the sorter (raster/frame_splats.h), for client/render. The CPU renderer sorts in
// raster/rasterise.cpp with radix_sort.
//
// A least-significant-digit radix sort with eight passes of four bits (Satish, Harris and Garland 2009,
// section 4, without the local sort). The result does not depend on the subgroup size or the order of
// atomics; the CPU functions give the same bits.
//
// Owns its buffers: 16 bytes per key, and 64 bytes per 2048 keys.
class KeySorter {
 public:
  // Creates a sorter for up to `capacity` keys, 1..kMaxKeys. The backend must outlive the sorter.
  static Result<KeySorter> create(Backend& backend, uint32_t capacity);

  struct Options {
    // values are the indices of the keys, 0 1 2 ...; the content of `values` is not read
    bool index_values = false;
    bool drops_keys = false;  // keys equal to kSortDroppedKey are removed with their values
  };

  // Sorts the first `count` entries of keys() and values() in place; count <= capacity. counted() then holds
  // the number of remaining keys.
  Result<void> sort(uint32_t count, const Options& options);

  // Sorts the first counted().instance_count entries, a number that a pass has written, at most the capacity.
  // Keys are below 2^key_bits. Afterwards keys() and values() may be other buffers than before.
  // `index_values`: as in Options.
  Result<void> sort_counted(uint32_t key_bits, bool index_values);

  BufferId keys() const { return buffers_[0].id(); }
  BufferId values() const { return buffers_[1].id(); }
  BufferId counted() const { return buffers_[5].id(); }  // one SortedCount
  uint32_t capacity() const { return capacity_; }
  size_t device_bytes() const;

  static constexpr uint32_t kMaxKeys = uint32_t{1} << 27;  // 2 GiB on the device; a device may bind fewer

 private:
  explicit KeySorter(Backend& backend) : backend_(&backend) {}
  Result<void> run_pass(uint32_t count, uint32_t shift, uint32_t flags);

  Backend* backend_;
  Buffer buffers_[6];  // keys, values, the same as sort targets, table, count
  uint32_t capacity_ = 0;
};

// The passes, for tests.
const Pass& sort_count_pass();
const Pass& sort_scan_pass();
const Pass& sort_scatter_pass();

}  // namespace livegs

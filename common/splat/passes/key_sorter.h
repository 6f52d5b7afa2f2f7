// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "compute/buffer.h"
#include "splat/passes/sort_keys_layout.h"

namespace livegs {

// Sorts 32-bit keys, each with a 32-bit value, where the passes run: ascending, equal keys in the order they
// came. Floats are sorted by ordered_key (radix_sort.h). A least-significant-digit radix sort of eight passes
// of four bits (Satish, Harris and Garland 2009, section 4, without its local sort). Nothing in it depends on
// the size of a subgroup, no sum on the order of atomics, and the CPU twins give the same bits.
//
// Owns its buffers, 16 bytes a key and 64 bytes for 2048 of them.
class KeySorter {
 public:
  // For up to `capacity` keys, 1..kMaxKeys; the backend outlives the sorter.
  static Result<KeySorter> create(Backend& backend, uint32_t capacity);

  struct Options {
    bool index_values = false;  // values are the keys' own places, 0 1 2 ...; what `values` holds is not read
    bool drops_keys = false;    // keys of kSortDroppedKey are left out, as are their values
  };

  // Sorts what the first `count` words of keys() and values() hold, count <= capacity, in place. counted()
  // then says how many are left.
  Result<void> sort(uint32_t count, const Options& options);

  BufferId keys() const { return buffers_[0].id(); }
  BufferId values() const { return buffers_[1].id(); }
  BufferId counted() const { return buffers_[5].id(); }  // one SortedCount
  uint32_t capacity() const { return capacity_; }
  size_t device_bytes() const;

  static constexpr uint32_t kMaxKeys = uint32_t{1} << 25;  // 128 MiB of keys: what lavapipe binds

 private:
  explicit KeySorter(Backend& backend) : backend_(&backend) {}
  Result<void> run_pass(uint32_t count, uint32_t shift, uint32_t flags);

  Backend* backend_;
  Buffer buffers_[6];  // keys, values, the same to sort into, table, count
  uint32_t capacity_ = 0;
};

// The passes, for tests.
const Pass& sort_count_pass();
const Pass& sort_scan_pass();
const Pass& sort_scatter_pass();

}  // namespace livegs

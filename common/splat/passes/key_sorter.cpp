// SPDX-License-Identifier: Apache-2.0
// Depth sort of the Vulkan renderer. Keys are from project_splats; FrameSplats::sort calls it. Shaders:
// sort_count, sort_scan, sort_scatter. Satish, Harris and Garland 2009, Designing efficient sorting
// algorithms for manycore GPUs.
#include "splat/passes/key_sorter.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "sort_count.spv.h"
#include "sort_scan.spv.h"
#include "sort_scatter.spv.h"

namespace livegs {
namespace {

constexpr uint32_t kPassDigitBits = 4;
static_assert(kSortDigits == 1u << kPassDigitBits);

uint32_t digit_of(uint32_t key, const SortKeysConstants& constants) {
  return (key >> constants.shift) % kSortDigits;
}

bool is_dropped(uint32_t key, const SortKeysConstants& constants) {
  return (constants.flags & kSortDropsKeys) != 0 && key == kSortDroppedKey;
}

uint32_t keys_here(const SortKeysConstants& constants, std::span<const std::byte> counted) {
  return (constants.flags & kSortFirstPass) != 0 ? constants.key_count
                                                 : row_at<SortedCount>(counted, 0).instance_count;
}

// CPU function of sort_count.comp.glsl. An item is a thread; ranges start at whole groups.
void sort_count(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<SortKeysConstants>(arguments.constants, 0);
  const std::span<const uint32_t> keys = words_of(arguments.buffers[0]);
  const std::span<uint32_t> table = words_of(arguments.buffers[2]);
  const size_t count = keys_here(constants, arguments.buffers[1]);
  LIVEGS_ASSERT(begin % kSortGroup == 0 && count <= keys.size());
  for (size_t tile = begin / kSortGroup; tile * kSortGroup < end; ++tile) {
    uint32_t counts[kSortDigits] = {};
    const size_t last = std::min(count, (tile + 1) * kSortTile);
    for (size_t i = tile * kSortTile; i < last; ++i) {
      if (!is_dropped(keys[i], constants)) ++counts[digit_of(keys[i], constants)];
    }
    for (uint32_t digit = 0; digit < kSortDigits; ++digit)
      table[digit * constants.tile_capacity + tile] = counts[digit];
  }
}

// CPU function of sort_scan.comp.glsl. Ranges start at whole groups, which are digits.
void sort_scan(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<SortKeysConstants>(arguments.constants, 0);
  const std::span<uint32_t> table = words_of(arguments.buffers[0]);
  for (size_t digit = begin / kSortGroup; digit * kSortGroup < end; ++digit) {
    uint32_t next = 0;
    for (uint32_t& entry : table.subspan(digit * constants.tile_capacity, constants.tile_capacity))
      next += std::exchange(entry, next);
    table[kSortDigits * constants.tile_capacity + digit] = next;
  }
}

// CPU function of sort_scatter.comp.glsl.
void sort_scatter(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<SortKeysConstants>(arguments.constants, 0);
  const std::span<const uint32_t> keys = words_of(arguments.buffers[0]);
  const std::span<const uint32_t> values = words_of(arguments.buffers[1]);
  const std::span<const uint32_t> table = words_of(arguments.buffers[2]);
  const std::span<uint32_t> sorted_keys = words_of(arguments.buffers[4]);
  const std::span<uint32_t> sorted_values = words_of(arguments.buffers[5]);
  const size_t count = keys_here(constants, arguments.buffers[3]);
  LIVEGS_ASSERT(begin % kSortGroup == 0 && count <= keys.size());
  uint32_t digit_begins[kSortDigits + 1] = {};
  for (uint32_t digit = 0; digit < kSortDigits; ++digit)
    digit_begins[digit + 1] = digit_begins[digit] + table[kSortDigits * constants.tile_capacity + digit];
  if ((constants.flags & kSortFirstPass) != 0 && begin == 0)
    set_row(arguments.buffers[3], 0, SortedCount{4, digit_begins[kSortDigits], 0, 0});
  for (size_t tile = begin / kSortGroup; tile * kSortGroup < end; ++tile) {
    uint32_t next[kSortDigits];
    for (uint32_t digit = 0; digit < kSortDigits; ++digit)
      next[digit] = digit_begins[digit] + table[digit * constants.tile_capacity + tile];
    const size_t last = std::min(count, (tile + 1) * kSortTile);
    for (size_t i = tile * kSortTile; i < last; ++i) {
      if (is_dropped(keys[i], constants)) continue;
      const uint32_t place = next[digit_of(keys[i], constants)]++;
      sorted_keys[place] = keys[i];
      sorted_values[place] = (constants.flags & kSortIndexValues) != 0 ? static_cast<uint32_t>(i) : values[i];
    }
  }
}

Pass sort_pass(std::string_view name, uint32_t buffers, std::span<const uint32_t> spirv,
               void (*run)(const PassArguments&, size_t, size_t)) {
  return {.name = name,
          .group_size = kSortGroup,
          .buffer_count = buffers,
          .constants_bytes = sizeof(SortKeysConstants),
          .spirv = spirv,
          .run = run};
}

uint32_t tiles_of(uint32_t keys) { return (keys + kSortTile - 1) / kSortTile; }

}  // namespace

const Pass& sort_count_pass() {
  static const Pass pass = sort_pass("sort_count", 3, sort_count_spirv, sort_count);
  return pass;
}

const Pass& sort_scan_pass() {
  static const Pass pass = sort_pass("sort_scan", 1, sort_scan_spirv, sort_scan);
  return pass;
}

const Pass& sort_scatter_pass() {
  static const Pass pass = sort_pass("sort_scatter", 6, sort_scatter_spirv, sort_scatter);
  return pass;
}

Result<KeySorter> KeySorter::create(Backend& backend, uint32_t capacity) {
  if (capacity == 0 || capacity > kMaxKeys) {
    return invalid_argument("key sorter: capacity " + std::to_string(capacity) + " is not from 1 to " +
                            std::to_string(kMaxKeys));
  }
  KeySorter sorter(backend);
  sorter.capacity_ = capacity;
  const size_t key_bytes = size_t{4} * capacity;
  const size_t sizes[6] = {
      key_bytes,          key_bytes, key_bytes, key_bytes, size_t{4} * kSortDigits * (tiles_of(capacity) + 1),
      sizeof(SortedCount)};
  for (size_t i = 0; i < std::size(sizes); ++i) {
    auto made = Buffer::create(backend, sizes[i]);
    if (!made) return made.error();
    sorter.buffers_[i] = *std::move(made);
  }
  return Result<KeySorter>(std::move(sorter));
}

size_t KeySorter::device_bytes() const {
  size_t bytes = 0;
  for (const Buffer& buffer : buffers_) bytes += buffer.bytes();
  return bytes;
}

Result<void> KeySorter::run_pass(uint32_t count, uint32_t shift, uint32_t flags) {
  auto& [keys, values, spare_keys, spare_values, table, counted] = buffers_;
  // A whole row of the table is always counted, so that unused tiles have zero counts.
  const uint32_t tiles = tiles_of(count);
  const SortKeysConstants constants{count, tiles, shift, flags};
  const auto bytes = std::as_bytes(std::span(&constants, 1));
  const std::array count_buffers{keys.id(), counted.id(), table.id()};
  const std::array scan_buffers{table.id()};
  const std::array scatter_buffers{keys.id(),    values.id(),     table.id(),
                                   counted.id(), spare_keys.id(), spare_values.id()};
  if (auto done = backend_->dispatch(sort_count_pass(), count_buffers, bytes, tiles * kSortGroup); !done)
    return done;
  if (auto done = backend_->dispatch(sort_scan_pass(), scan_buffers, bytes, kSortDigits * kSortGroup); !done)
    return done;
  if (auto done = backend_->dispatch(sort_scatter_pass(), scatter_buffers, bytes, tiles * kSortGroup); !done)
    return done;
  std::swap(keys, spare_keys);
  std::swap(values, spare_values);
  return {};
}

Result<void> KeySorter::sort(uint32_t count, const Options& options) {
  if (count > capacity_) {
    return invalid_argument("key sorter: " + std::to_string(count) + " keys exceed the capacity of " +
                            std::to_string(capacity_));
  }
  if (count == 0) {
    const SortedCount none{4, 0, 0, 0};
    return backend_->upload(buffers_[5].id(), std::as_bytes(std::span(&none, 1)));
  }
  for (uint32_t shift = 0; shift < 32; shift += kPassDigitBits) {
    uint32_t flags = 0;
    if (shift == 0) {
      flags = kSortFirstPass | (options.index_values ? kSortIndexValues : 0u) |
              (options.drops_keys ? kSortDropsKeys : 0u);
    }
    if (auto done = run_pass(count, shift, flags); !done) return done;
  }
  return {};  // the number of passes is even: keys() and values() are the same buffers as before
}

Result<void> KeySorter::sort_counted(uint32_t key_bits, bool index_values) {
  for (uint32_t shift = 0; shift < key_bits; shift += kPassDigitBits) {
    if (auto done = run_pass(capacity_, shift, shift == 0 && index_values ? kSortIndexValues : 0); !done)
      return done;
  }
  return {};
}

}  // namespace livegs

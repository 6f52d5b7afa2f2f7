// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

// The order of kernels by their depth keys on one thread, for the browser client. The same order as
// radix_sort(), which several threads share.

namespace livegs {

// Unsigned keys in the order of the floats, including negative numbers; -0 is directly before +0.
inline uint32_t ordered_key(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

// Keys (ordered_key) of consecutive kernels.
struct KeyRun {
  std::span<const uint32_t> keys;
  uint32_t first_index = 0;
};

// Keeps its memory for the next call. One thread.
class KeyOrder {
 public:
  // Indices of all kernels, ascending by key; equal keys in the order of the runs. Only the bits in which
  // keys differ are sorted: kernels in front of an eye, within a few octaves of depth, take two passes.
  // At most 2^32 - 1 kernels.
  std::span<const uint32_t> sort(std::span<const KeyRun> runs);
  std::span<const uint32_t> order() const { return order_; }  // of the last sort()

 private:
  template <int passes>
  void sort_digits(std::span<const KeyRun> runs, uint32_t low, int digit_bits);

  std::vector<uint32_t> order_, slots_;
  std::vector<uint64_t> items_, scratch_;  // key above index
};

}  // namespace livegs

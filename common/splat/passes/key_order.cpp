// SPDX-License-Identifier: Apache-2.0
#include "splat/passes/key_order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace livegs {
namespace {

// Bits of a digit, at most. Larger digits have more counters than the caches hold at hand, smaller ones need
// another pass over all kernels.
constexpr int kMaxDigitBits = 14;

}  // namespace

template <int passes>
void KeyOrder::sort_digits(std::span<const KeyRun> runs, uint32_t low, int digit_bits) {
  const size_t digits = size_t{1} << digit_bits;
  const uint32_t mask = static_cast<uint32_t>(digits - 1);
  slots_.assign(passes * digits, 0);
  std::array<uint32_t*, passes> slots;
  for (int pass = 0; pass < passes; ++pass)
    slots[static_cast<size_t>(pass)] = slots_.data() + static_cast<size_t>(pass) * digits;
  for (const KeyRun& run : runs) {
    for (const uint32_t key : run.keys) {
      for (int pass = 0; pass < passes; ++pass)
        ++slots[static_cast<size_t>(pass)][((key - low) >> (pass * digit_bits)) & mask];
    }
  }
  for (uint32_t* of_pass : slots) {
    uint32_t next = 0;
    for (size_t digit = 0; digit < digits; ++digit) next += std::exchange(of_pass[digit], next);
  }
  items_.resize(passes > 1 ? order_.size() : 0);
  scratch_.resize(passes > 2 ? order_.size() : 0);
  for (const KeyRun& run : runs) {
    uint32_t index = run.first_index;
    for (const uint32_t key : run.keys) {
      const uint32_t rest = key - low, slot = slots[0][rest & mask]++;
      if constexpr (passes == 1)
        order_[slot] = index++;
      else
        items_[slot] = uint64_t{rest} << 32 | index++;
    }
  }
  for (int pass = 1; pass < passes; ++pass) {
    uint32_t* const of_pass = slots[static_cast<size_t>(pass)];
    const int shift = 32 + pass * digit_bits;
    if (pass + 1 == passes) {
      for (const uint64_t item : items_)
        order_[of_pass[(item >> shift) & mask]++] = static_cast<uint32_t>(item);
    } else {
      for (const uint64_t item : items_) scratch_[of_pass[(item >> shift) & mask]++] = item;
      items_.swap(scratch_);
    }
  }
}

std::span<const uint32_t> KeyOrder::sort(std::span<const KeyRun> runs) {
  size_t count = 0;
  uint32_t low = ~0u, high = 0;
  for (const KeyRun& run : runs) {
    count += run.keys.size();
    for (const uint32_t key : run.keys) {
      low = std::min(low, key);
      high = std::max(high, key);
    }
  }
  order_.resize(count);
  if (count == 0) return order_;
  const int bits = std::max(1, static_cast<int>(std::bit_width(high - low)));
  if (bits <= kMaxDigitBits)
    sort_digits<1>(runs, low, bits);
  else if (bits <= 2 * kMaxDigitBits)
    sort_digits<2>(runs, low, (bits + 1) / 2);
  else
    sort_digits<3>(runs, low, (bits + 2) / 3);
  return order_;
}

}  // namespace livegs

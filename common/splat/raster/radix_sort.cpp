// SPDX-License-Identifier: Apache-2.0
// Depth sort of the CPU renderer; rasterise.cpp calls it. The sort of the GPU is passes/key_sorter.cpp.
#include "splat/raster/radix_sort.h"

#include <array>

#include "core/parallel_for.h"

namespace livegs {
namespace {

constexpr int kDigitBits = 11;
constexpr size_t kDigits = size_t{1} << kDigitBits;
constexpr int kPasses = 3;  // 33 bits
constexpr size_t kHistogramBlock =
    1 << 16;  // items per histogram; the 2048 counters are then 3 % of the work

uint32_t digit_of(uint32_t key, int pass) { return (key >> (pass * kDigitBits)) & (kDigits - 1); }

}  // namespace

void radix_sort(std::vector<KeyedIndex>& items, std::vector<KeyedIndex>& scratch) {
  scratch.resize(items.size());
  const size_t blocks = (items.size() + kHistogramBlock - 1) / kHistogramBlock;
  std::vector<std::array<uint32_t, kDigits>> first(
      blocks);  // counts, then the start of the block's run of each digit
  for (int pass = 0; pass < kPasses; ++pass) {
    parallel_for(items.size(), kHistogramBlock, [&](size_t begin, size_t end) {
      auto& counts = first[begin / kHistogramBlock];
      counts.fill(0);
      for (size_t i = begin; i < end; ++i) ++counts[digit_of(items[i].key, pass)];
    });
    uint32_t next = 0;
    bool all_agree = false;
    for (size_t digit = 0; digit < kDigits; ++digit) {
      const uint32_t digit_begin = next;
      for (auto& counts : first) {
        const uint32_t count = counts[digit];
        counts[digit] = next;
        next += count;
      }
      all_agree |= next - digit_begin == items.size();
    }
    if (all_agree) continue;
    parallel_for(items.size(), kHistogramBlock, [&](size_t begin, size_t end) {
      auto& slots = first[begin / kHistogramBlock];
      for (size_t i = begin; i < end; ++i) scratch[slots[digit_of(items[i].key, pass)]++] = items[i];
    });
    items.swap(scratch);
  }
}

}  // namespace livegs

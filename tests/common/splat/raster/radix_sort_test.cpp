// SPDX-License-Identifier: Apache-2.0
#include "splat/raster/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/splat/synthetic_kernels.h"
#include "splat/passes/key_order.h"

namespace livegs {
namespace {

std::vector<KeyedIndex> sorted_by_us(std::vector<KeyedIndex> items) {
  std::vector<KeyedIndex> scratch;
  radix_sort(items, scratch);
  return items;
}

void expect_stable_order(const std::vector<KeyedIndex>& items) {
  std::vector<KeyedIndex> expected = items;
  std::stable_sort(expected.begin(), expected.end(),
                   [](const KeyedIndex& a, const KeyedIndex& b) { return a.key < b.key; });
  const std::vector<KeyedIndex> sorted = sorted_by_us(items);
  ASSERT_EQ(sorted.size(), expected.size());
  for (size_t i = 0; i < sorted.size(); ++i) {
    ASSERT_EQ(sorted[i].key, expected[i].key) << i;
    ASSERT_EQ(sorted[i].index, expected[i].index) << i;
  }
}

std::vector<KeyedIndex> random_items(size_t count, double distinct_keys, uint64_t seed) {
  synthetic::Random random(seed);
  std::vector<KeyedIndex> items;
  for (size_t i = 0; i < count; ++i) {
    items.push_back({static_cast<uint32_t>(random.uniform(0, distinct_keys)), static_cast<uint32_t>(i)});
  }
  return items;
}

TEST(RadixSort, SortsWordsStably) {
  for (const size_t count : {0u, 1u, 2u, 1000u, 65'536u, 65'537u, 200'000u}) {
    expect_stable_order(random_items(count, 0x1p32, count + 1));
    expect_stable_order(random_items(count, 10.0, count + 2));
    expect_stable_order(random_items(count, 1.0, count + 3));
  }
}

// Runs of one, two and three passes, in the order that radix_sort gives.
TEST(RadixSort, KeyOrderIsTheSameOrder) {
  KeyOrder order;
  for (const double distinct : {1.0, 5000.0, 0x1p20, 0x1p32}) {
    for (const size_t count : {0u, 1u, 1000u, 70'001u}) {
      const std::vector<KeyedIndex> items = random_items(count, distinct, count + 7);
      std::vector<uint32_t> keys;
      for (const KeyedIndex& item : items) keys.push_back(item.key);
      const size_t half = count / 3;
      const KeyRun runs[] = {{std::span(keys).first(half), 0}, {}, {std::span(keys).subspan(half), 500'000}};
      const std::span<const uint32_t> found = order.sort(runs);
      const std::vector<KeyedIndex> expected = sorted_by_us(items);
      ASSERT_EQ(found.size(), count);
      for (size_t i = 0; i < count; ++i) {
        const uint32_t index = expected[i].index;
        ASSERT_EQ(found[i], index < half ? index : 500'000 + index - half) << i;
      }
    }
  }
}

TEST(RadixSort, FloatKeysKeepTheFloatOrder) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float rising[] = {-infinity, -1e30f, -2.0f,  -1.0f, -1e-30f, -1e-42f, -0.0f,
                          0.0f,      1e-42f, 1e-30f, 1.0f,  2.0f,    1e30f,   infinity};
  for (size_t i = 1; i < std::size(rising); ++i)
    EXPECT_LT(ordered_key(rising[i - 1]), ordered_key(rising[i])) << i;
}

}  // namespace
}  // namespace livegs

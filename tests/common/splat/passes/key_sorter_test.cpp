// SPDX-License-Identifier: Apache-2.0
#include "splat/passes/key_sorter.h"
#include "splat/passes/key_order.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "common/compute/backends.h"
#include "common/splat/synthetic_kernels.h"

namespace livegs {
namespace {

// Expected results are exact, because sorting only moves words.
class KeySorterTest : public OnEveryBackend {
 protected:
  struct Sorted {
    std::vector<uint32_t> keys, values;
  };

  // Sorts with room for `spare` more keys; fails the test if the sorter fails.
  Sorted sort(const std::vector<uint32_t>& keys, const std::vector<uint32_t>& values,
              const KeySorter::Options& options, uint32_t spare = 1) {
    const auto count = static_cast<uint32_t>(keys.size());
    auto sorter = KeySorter::create(*backend_, count + spare);
    EXPECT_TRUE(sorter) << sorter.error().message;
    if (!sorter) return {};
    EXPECT_TRUE(backend_->upload(sorter->keys(), std::as_bytes(std::span(keys))));
    EXPECT_TRUE(backend_->upload(sorter->values(), std::as_bytes(std::span(values))));
    const auto done = sorter->sort(count, options);
    EXPECT_TRUE(done) << done.error().message;
    const auto counted = read_all<SortedCount>(sorter->counted(), 1)[0];
    EXPECT_EQ(counted.vertex_count, 4u);
    EXPECT_EQ(counted.first_vertex, 0u);
    EXPECT_EQ(counted.first_instance, 0u);
    EXPECT_LE(counted.instance_count, count);
    return {read_all<uint32_t>(sorter->keys(), counted.instance_count),
            read_all<uint32_t>(sorter->values(), counted.instance_count)};
  }

  void expect_stable_order(const std::vector<uint32_t>& keys) {
    std::vector<uint32_t> places(keys.size());
    std::iota(places.begin(), places.end(), 0u);
    std::vector<uint32_t> order = places;
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return keys[a] < keys[b]; });
    std::vector<uint32_t> expected;
    for (const uint32_t i : order) expected.push_back(keys[i]);
    const Sorted indexed = sort(keys, std::vector<uint32_t>(keys.size(), 77), {.index_values = true});
    ASSERT_TRUE(indexed.keys == expected);
    ASSERT_TRUE(indexed.values == order);

    for (uint32_t& place : places) place = 3 * place + 1;
    for (uint32_t& place : order) place = 3 * place + 1;
    const Sorted given = sort(keys, places, {});
    ASSERT_TRUE(given.keys == expected);
    ASSERT_TRUE(given.values == order);
  }
};
INSTANTIATE_TEST_SUITE_P(Backend, KeySorterTest, testing::Values("cpu", "vulkan"), backend_name);

std::vector<uint32_t> random_keys(size_t count, double distinct, uint64_t seed) {
  synthetic::Random random(seed);
  std::vector<uint32_t> keys(count);
  for (uint32_t& key : keys) key = static_cast<uint32_t>(random.uniform(0, distinct));
  return keys;
}

TEST_P(KeySorterTest, SortsWordsStably) {
  for (const size_t count : {1u, 2u, 7u, 8u, 9u, 255u, 2047u, 2048u, 2049u, 65'537u, 200'003u}) {
    SCOPED_TRACE(count);
    ASSERT_NO_FATAL_FAILURE(expect_stable_order(random_keys(count, 0x1p32, count)));
    ASSERT_NO_FATAL_FAILURE(expect_stable_order(random_keys(count, 10.0, count + 1)));
  }
  ASSERT_NO_FATAL_FAILURE(expect_stable_order(std::vector<uint32_t>(5000, 0xffffffffu)));
  ASSERT_NO_FATAL_FAILURE(expect_stable_order(std::vector<uint32_t>(5000, 0u)));
}

TEST_P(KeySorterTest, SortsSortedAndReversedKeys) {
  std::vector<uint32_t> keys(10'000);
  std::iota(keys.begin(), keys.end(), 0xfffffff0u - 10'000u);
  ASSERT_NO_FATAL_FAILURE(expect_stable_order(keys));
  std::reverse(keys.begin(), keys.end());
  ASSERT_NO_FATAL_FAILURE(expect_stable_order(keys));
}

TEST_P(KeySorterTest, AcceptsNoKeys) {
  const Sorted sorted = sort({}, {}, {.index_values = true});
  EXPECT_TRUE(sorted.keys.empty());
}

TEST_P(KeySorterTest, SortsFloatsOfBothSigns) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  synthetic::Random random(3);
  std::vector<float> floats{-kInfinity, kInfinity, 0.0f, -0.0f, 1e-42f, -1e-42f, 1e30f, -1e30f};
  while (floats.size() < 10'000) floats.push_back(static_cast<float>(100.0 * random.normal()));
  std::vector<uint32_t> keys;
  for (const float value : floats) keys.push_back(ordered_key(value));
  const Sorted sorted = sort(keys, std::vector<uint32_t>(keys.size()), {.index_values = true});
  ASSERT_EQ(sorted.values.size(), floats.size());
  for (size_t i = 1; i < floats.size(); ++i)
    ASSERT_LE(floats[sorted.values[i - 1]], floats[sorted.values[i]]) << i;
}

TEST_P(KeySorterTest, RemovesDroppedKeys) {
  std::vector<uint32_t> keys = random_keys(30'000, 5.0, 4);
  for (uint32_t& key : keys) {
    if (key >= 3) key = kSortDroppedKey;
  }
  std::vector<uint32_t> expected;
  for (uint32_t key = 0; key < 3; ++key) {
    for (uint32_t i = 0; i < keys.size(); ++i) {
      if (keys[i] == key) expected.push_back(i);
    }
  }
  const Sorted sorted =
      sort(keys, std::vector<uint32_t>(keys.size()), {.index_values = true, .drops_keys = true});
  EXPECT_TRUE(sorted.values == expected);
  const Sorted none = sort(std::vector<uint32_t>(3000, kSortDroppedKey), std::vector<uint32_t>(3000),
                           {.index_values = true, .drops_keys = true});
  EXPECT_TRUE(none.keys.empty());
}

// Stale keys beyond the count, from a larger frame, are ignored.
TEST_P(KeySorterTest, IgnoresKeysBeyondTheCount) {
  auto sorter = KeySorter::create(*backend_, 50'000);
  ASSERT_TRUE(sorter);
  for (const uint32_t count : {50'000u, 4100u, 3u, 0u, 20'000u}) {
    const std::vector<uint32_t> keys = random_keys(count, 0x1p32, count);
    ASSERT_TRUE(backend_->upload(sorter->keys(), std::as_bytes(std::span(keys))));
    ASSERT_TRUE(sorter->sort(count, {.index_values = true}));
    ASSERT_EQ(read_all<SortedCount>(sorter->counted(), 1)[0].instance_count, count);
    auto expected = keys;
    std::sort(expected.begin(), expected.end());
    ASSERT_TRUE(read_all<uint32_t>(sorter->keys(), count) == expected) << count;
  }
}

TEST_P(KeySorterTest, RejectsCountsAboveCapacity) {
  for (const uint32_t capacity : {0u, KeySorter::kMaxKeys + 1}) {
    const auto sorter = KeySorter::create(*backend_, capacity);
    ASSERT_FALSE(sorter);
    EXPECT_EQ(sorter.error().code, ErrorCode::InvalidArgument);
  }
  auto sorter = KeySorter::create(*backend_, 10);
  ASSERT_TRUE(sorter);
  EXPECT_EQ(sorter->sort(11, {}).error().code, ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "common/compute/backends.h"
#include "common/splat/synthetic_kernels.h"
#include "splat/key_sorter.h"

namespace livegs {
namespace {

using KeySorterLargeTest = OnEveryBackend;
INSTANTIATE_TEST_SUITE_P(Backend, KeySorterLargeTest, testing::Values("cpu", "vulkan"), backend_name);

std::vector<uint32_t> random_keys(size_t count, uint64_t seed) {
  synthetic::Random random(seed);
  std::vector<uint32_t> keys(count);
  for (uint32_t& key : keys) key = static_cast<uint32_t>(random.uniform(0, 0x1p32));
  return keys;
}

TEST_P(KeySorterLargeTest, FourMillionKeysAreSorted) {
  const std::vector<uint32_t> keys = random_keys(size_t{4} << 20, 5);
  auto sorter = KeySorter::create(*backend_, size_t{4} << 20);
  ASSERT_TRUE(sorter) << sorter.error().message;
  ASSERT_TRUE(backend_->upload(sorter->keys(), std::as_bytes(std::span(keys))));
  ASSERT_TRUE(sorter->sort(size_t{4} << 20, {.index_values = true}));
  const auto sorted = read_all<uint32_t>(sorter->keys(), keys.size());
  const auto values = read_all<uint32_t>(sorter->values(), keys.size());
  std::vector<bool> seen(keys.size());
  for (size_t i = 0; i < keys.size(); ++i) {
    ASSERT_EQ(sorted[i], keys[values[i]]);
    ASSERT_FALSE(seen[values[i]]);
    seen[values[i]] = true;
    if (i == 0) continue;
    ASSERT_LE(sorted[i - 1], sorted[i]);
    if (sorted[i - 1] == sorted[i]) {
      ASSERT_LT(values[i - 1], values[i]);
    }
  }
}

}  // namespace
}  // namespace livegs

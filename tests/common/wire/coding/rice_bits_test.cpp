// SPDX-License-Identifier: Apache-2.0
#include "wire/coding/rice_bits.h"

#include <gtest/gtest.h>

#include <random>

namespace livegs {
namespace {

// Alternates small numbers, numbers with 24 or more leading zeros in the code, and full 32-bit numbers.
uint32_t number(std::mt19937& random, int k) {
  const uint32_t all = static_cast<uint32_t>(random());
  switch (random() % 8) {
    case 0:
      return all;
    case 1:
      return ((kMaxZeros - 2 + all % 4) << k) | (all >> 8 & ((1u << k) - 1));
    default:
      return all >> (31 - std::min(31, k + static_cast<int>(random() % 5)));
  }
}

TEST(RiceBits, ThreeAtOnceEqualThreeSingleCodes) {
  std::mt19937 random(1);
  constexpr size_t kTriples = 2000;
  for (int k = 0; k <= kMaxRiceBits; ++k) {
    std::vector<std::array<uint32_t, 3>> triples(kTriples);
    std::vector<std::byte> together_buffer, apart_buffer, read_buffer;
    RiceWriter together(together_buffer, 3 * kTriples), apart(apart_buffer, 3 * kTriples);
    for (std::array<uint32_t, 3>& triple : triples) {
      for (uint32_t& value : triple) {
        value = number(random, k);
        apart.code(value, k);
      }
      together.three(triple, k);
    }
    const auto written = together.written(), expected = apart.written();
    ASSERT_TRUE(std::equal(written.begin(), written.end(), expected.begin(), expected.end())) << k;
    RiceReader reader(read_buffer, written);
    for (const std::array<uint32_t, 3>& triple : triples) {
      std::array<uint32_t, 3> read{};
      reader.three(read, k);
      ASSERT_EQ(read, triple) << k;
    }
    EXPECT_TRUE(reader.at_end()) << k;
  }
}

}  // namespace
}  // namespace livegs

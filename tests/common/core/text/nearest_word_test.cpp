// SPDX-License-Identifier: Apache-2.0
#include "core/text/nearest_word.h"

#include <gtest/gtest.h>

#include <vector>

namespace livegs {
namespace {

TEST(NearestWord, DistanceCountsEditsAndExchanges) {
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("name", "name"), 0u);
  EXPECT_EQ(edit_distance("nme", "name"), 1u);
  EXPECT_EQ(edit_distance("naem", "name"), 1u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
}

TEST(NearestWord, IsTheFirstOfTheNearestOrNone) {
  const std::vector<std::string> words = {"name", "asset", "mass_kg", "mask_kg"};
  EXPECT_EQ(nearest_word("nme", words), "name");
  EXPECT_EQ(nearest_word("ASSETS", words), "asset");
  EXPECT_EQ(nearest_word("mas_kg", words), "mass_kg");
  EXPECT_EQ(nearest_word("maxx_kg", words), "mass_kg");
  EXPECT_EQ(nearest_word("colour", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(nearest_word(std::string(100'000, 'a'), words), "");
}

}  // namespace
}  // namespace livegs

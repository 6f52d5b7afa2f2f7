// SPDX-License-Identifier: Apache-2.0
#include "core/text/format_text.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

TEST(FormatText, MatchesPrintfAtAnyLength) {
  EXPECT_EQ(format_text("%d of %.3g %s, %.0f %%", 2, 0.125, "kg", 41.7), "2 of 0.125 kg, 42 %");
  EXPECT_EQ(format_text("%s", ""), "");
  const std::string longer(5000, 'x');
  EXPECT_EQ(format_text("<%s>", longer.c_str()), "<" + longer + ">");
  EXPECT_EQ(format_text("%.3s", longer.c_str()), "xxx");
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "core/result.h"

#include <gtest/gtest.h>

#include <memory>

namespace livegs {
namespace {

Result<int> half(int value) {
  if (value % 2) return invalid_argument(std::to_string(value) + ": is odd");
  return value / 2;
}

TEST(Result, HoldsAValueOrAnError) {
  EXPECT_EQ(half(6).value(), 3);
  ASSERT_FALSE(half(5));
  EXPECT_EQ(half(5).error().message, "5: is odd");
  EXPECT_EQ(half(5).error().code, ErrorCode::InvalidArgument);
}

TEST(Result, SupportsMoveOnlyValues) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(4);
  std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 4);
}

TEST(ResultDeathTest, ValueOfAnErrorPrintsItsMessage) { EXPECT_DEATH((void)half(3).value(), "3: is odd"); }

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "core/log.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

TEST(Log, RemovesControlCharacters) {
  testing::internal::CaptureStderr();
  log_warn("%s: is red", "a\nb\x1b[31m\x7f\xc3\xbc");
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("a b [31m \xc3\xbc: is red\n"), std::string::npos) << said;
  EXPECT_EQ(said.find('\n'), said.size() - 1);
}

}  // namespace
}  // namespace livegs

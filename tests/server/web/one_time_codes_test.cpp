// SPDX-License-Identifier: Apache-2.0
#include "web/one_time_codes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <set>

namespace livegs {
namespace {

class OneTimeCode : public ::testing::Test {
 protected:
  int64_t now_ns_ = 0;
  OneTimeCodes codes_{[this] { return now_ns_; }};
};

TEST_F(OneTimeCode, WorksOnceAsTyped) {
  const std::string code = *codes_.create();
  EXPECT_EQ(code.size(), 8u);
  std::string typed = " " + code.substr(0, 4) + "-" + code.substr(4);
  std::transform(typed.begin(), typed.end(), typed.begin(), [](unsigned char c) { return std::tolower(c); });
  EXPECT_TRUE(codes_.use(typed));
  EXPECT_FALSE(codes_.use(code));
}

TEST_F(OneTimeCode, DiesAfterFiveWrongTries) {
  const std::string code = *codes_.create();
  for (int i = 0; i < kMaxCodeTries; ++i) EXPECT_FALSE(codes_.use("22222222"));
  EXPECT_FALSE(codes_.use(code));
}

TEST_F(OneTimeCode, ExpiresAfterTenMinutes) {
  const std::string first = *codes_.create();
  now_ns_ = kOneTimeCodeLifetime_ns;
  EXPECT_TRUE(codes_.use(first));
  const std::string second = *codes_.create();
  now_ns_ += kOneTimeCodeLifetime_ns + 1;
  EXPECT_FALSE(codes_.use(second));
}

TEST_F(OneTimeCode, ReplacesTheEarlierOne) {
  const std::string first = *codes_.create(), second = *codes_.create();
  EXPECT_FALSE(codes_.use(first));
  EXPECT_TRUE(codes_.use(second));
  std::set<std::string> all;
  for (int i = 0; i < 1000; ++i) all.insert(*codes_.create());
  EXPECT_EQ(all.size(), 1000u);
}

TEST_F(OneTimeCode, NoneIsValidAtTheStart) {
  EXPECT_FALSE(codes_.use(""));
  EXPECT_FALSE(codes_.use("AAAAAAAA"));
}

}  // namespace
}  // namespace livegs

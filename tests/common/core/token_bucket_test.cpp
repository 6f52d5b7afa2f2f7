// SPDX-License-Identifier: Apache-2.0
#include "core/token_bucket.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

TEST(TokenBucket, LimitsTheRateAndTheBurst) {
  TokenBucket bucket(10, 25);
  int64_t now = 5 * kSecond_ns;
  const auto taken = [&](int tries) {
    int count = 0;
    for (int i = 0; i < tries; ++i) count += bucket.try_take(now) ? 1 : 0;
    return count;
  };
  EXPECT_EQ(taken(100), 25);
  now += kSecond_ns;
  EXPECT_EQ(taken(100), 10);
  now += kSecond_ns / 2;
  EXPECT_EQ(taken(100), 5);
  now += 3600 * kSecond_ns;
  EXPECT_EQ(taken(100), 25);
  int steady = 0;
  for (int i = 0; i < 1000; ++i) {  // ten seconds in steps that do not divide evenly
    now += kSecond_ns / 100;
    steady += bucket.try_take(now) ? 1 : 0;
  }
  EXPECT_NEAR(steady, 100, 1);
}

TEST(TokenBucket, GoesIntoDebtAtItsRate) {
  TokenBucket bucket(2.0, 3.0);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(bucket.take_in_debt(0), 0);
  EXPECT_EQ(bucket.take_in_debt(0), 500000000);   // debt of one at 2 tokens per second
  EXPECT_EQ(bucket.take_in_debt(0), 1000000000);  // two
  EXPECT_EQ(bucket.take_in_debt(2000000000), 0);  // 2 s give 4 tokens: the debt of 2 and 2 more
}

TEST(TokenBucket, KeepsSavedTokensWhenItsRateChanges) {
  TokenBucket bucket(10, 10);
  EXPECT_EQ(bucket.refill(0), 10);
  bucket.set_rate(100, 5);
  EXPECT_EQ(bucket.refill(0), 5);
  bucket.set_rate(100, 50);
  EXPECT_EQ(bucket.refill(0), 5);
  EXPECT_DOUBLE_EQ(bucket.refill(kSecond_ns / 10), 15);
  EXPECT_DOUBLE_EQ(bucket.refill(0), 15);  // an earlier time adds nothing
}

}  // namespace
}  // namespace livegs

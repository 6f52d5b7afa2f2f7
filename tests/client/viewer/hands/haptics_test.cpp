// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/haptics.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

constexpr int64_t ms(int64_t milliseconds) { return milliseconds * 1'000'000; }

TEST(Haptics, PredictedContactIsFeltOnce) {
  Haptics feel;
  EXPECT_FALSE(feel.foreseen(1, false, 1.0, ms(0)));
  const auto pulse = feel.foreseen(1, true, 1.0, ms(11));
  ASSERT_TRUE(pulse);
  EXPECT_GT(pulse->amplitude, 0.5f);
  for (int i = 2; i < 50; ++i) EXPECT_FALSE(feel.foreseen(1, true, 1.0, ms(11 * i)));
  EXPECT_FALSE(feel.foreseen(1, false, 1.0, ms(600)));
  const auto softer = feel.foreseen(1, true, 0.1, ms(700));
  ASSERT_TRUE(softer);
  EXPECT_LT(softer->amplitude, pulse->amplitude);
  EXPECT_FALSE(feel.foreseen(0, true, 1.0, ms(700)));  // the other hand: initial state
}

// The server's report of the same contact is not felt again, however long it lasts.
TEST(Haptics, PredictedContactIsNotRepeatedWhenReported) {
  Haptics feel;
  EXPECT_TRUE(feel.holds(0, 7));
  EXPECT_FALSE(feel.foreseen(0, false, 1.0, ms(0)));
  EXPECT_TRUE(feel.foreseen(0, true, 1.0, ms(100)));
  for (int i = 0; i < 200; ++i) EXPECT_FALSE(feel.reported(0, 0.1f, ms(180 + 11 * i)));
  // A stronger impact during it is felt.
  EXPECT_TRUE(feel.reported(0, 0.9f, ms(180 + 2200)));
}

TEST(Haptics, ReportedContactIsNotRepeatedWhenPredicted) {
  Haptics feel;
  EXPECT_TRUE(feel.holds(0, 7));
  EXPECT_FALSE(feel.foreseen(0, false, 1.0, ms(0)));
  EXPECT_TRUE(feel.reported(0, 0.1f, ms(50)));
  EXPECT_FALSE(feel.foreseen(0, true, 1.0, ms(60)));
  EXPECT_FALSE(feel.reported(0, 0.1f, ms(70)));
  // A new contact after a pause.
  EXPECT_TRUE(feel.reported(0, 0.1f, ms(1000)));
}

// A grabbed object already touches the table, with an impulse of m g dt per tick.
TEST(Haptics, GrabIsFeltButInitialContactIsNot) {
  Haptics feel;
  const auto took = feel.holds(0, 7);
  ASSERT_TRUE(took);
  EXPECT_FALSE(feel.holds(0, 7));
  EXPECT_FALSE(feel.foreseen(0, true, 1.0, ms(11)));
  EXPECT_FALSE(feel.foreseen(0, true, 1.0, ms(22)));
  EXPECT_FALSE(feel.holds(0, 0));  // releasing is not felt
}

// A hand that first appears inside an object has not just touched it.
TEST(Haptics, FirstPredictionSetsStateWithoutPulse) {
  Haptics feel;
  EXPECT_FALSE(feel.foreseen(0, false, 1.0, ms(0)));
  feel.on_no_prediction(0);
  EXPECT_FALSE(feel.foreseen(0, true, 1.0, ms(11)));
}

TEST(Haptics, WeakImpulseIsNotFelt) {
  Haptics feel;
  EXPECT_FALSE(feel.reported(0, 0.01f, ms(0)));
  const auto strong = feel.reported(0, 50.0f, ms(10));
  ASSERT_TRUE(strong);
  EXPECT_EQ(strong->amplitude, 1.0f);
}

}  // namespace
}  // namespace livegs

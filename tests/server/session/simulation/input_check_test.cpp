// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <limits>

#include "session/simulation/input_check.h"

namespace livegs {
namespace {

v1::HandInput plain_hand() {
  v1::HandInput hand;
  for (float value : {0.1f, 1.2f, 0.3f}) {
    hand.add_aim_position_m(value);
    hand.add_grip_position_m(value);
  }
  for (float value : {1.0f, 0.0f, 0.0f, 0.0f}) {
    hand.add_aim_orientation(value);
    hand.add_grip_orientation(value);
  }
  hand.set_trigger(0.75f);
  return hand;
}

v1::ClientMessage plain_message() {
  v1::ClientMessage message;
  for (uint64_t sequence = 1; sequence <= 3; ++sequence) {
    v1::Input& input = *message.add_inputs();
    input.set_sequence(sequence);
    *input.mutable_right() = plain_hand();
  }
  return message;
}

TEST(InputCheck, ReadsHandsAndMarksUntrackedInactive) {
  const auto samples = check_inputs(plain_message());
  ASSERT_TRUE(samples) << samples.error().message;
  ASSERT_EQ(samples->size(), 3u);
  EXPECT_FALSE((*samples)[0].hands[0].active);
  EXPECT_TRUE((*samples)[0].hands[1].active);
  EXPECT_FLOAT_EQ((*samples)[0].hands[1].trigger, 0.75f);
  EXPECT_EQ((*samples)[2].sequence, 3u);
}

TEST(InputCheck, RefusesUnphysicalInputByField) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const struct {
    const char* field;
    std::function<void(v1::ClientMessage&)> spoil;
  } cases[] = {
      {"inputs[1].right.aim_position_m",
       [&](auto& m) { m.mutable_inputs(1)->mutable_right()->set_aim_position_m(0, nan); }},
      {"inputs[0].right.aim_position_m",
       [&](auto& m) { m.mutable_inputs(0)->mutable_right()->set_aim_position_m(2, infinity); }},
      {"inputs[0].right.grip_position_m",
       [&](auto& m) { m.mutable_inputs(0)->mutable_right()->set_grip_position_m(1, 1e9f); }},
      {"inputs[0].right.aim_orientation",
       [&](auto& m) { m.mutable_inputs(0)->mutable_right()->set_aim_orientation(0, nan); }},
      {"inputs[0].right.aim_orientation",
       [&](auto& m) { m.mutable_inputs(0)->mutable_right()->set_aim_orientation(0, 0.0f); }},
      {"inputs[0].right.grip_orientation",
       [&](auto& m) { m.mutable_inputs(0)->mutable_right()->add_grip_orientation(0.0f); }},
      {"inputs[0].right.aim_position_m",
       [&](auto& m) { m.mutable_inputs(0)->mutable_right()->clear_aim_position_m(); }},
      {"inputs[2].right", [&](auto& m) { m.mutable_inputs(2)->mutable_right()->set_trigger(1.5f); }},
      {"inputs[2].right", [&](auto& m) { m.mutable_inputs(2)->mutable_right()->set_squeeze(nan); }},
      {"inputs[1].sequence", [&](auto& m) { m.mutable_inputs(1)->set_sequence(1); }},
      {"inputs[0].sequence", [&](auto& m) { m.mutable_inputs(0)->set_sequence(0); }},
  };
  for (const auto& one : cases) {
    v1::ClientMessage message = plain_message();
    one.spoil(message);
    const auto samples = check_inputs(message);
    ASSERT_FALSE(samples) << one.field;
    EXPECT_EQ(samples.error().message.rfind(one.field, 0), 0u) << samples.error().message;
  }
}

TEST(InputCheck, ReadsAViewOrNamesTheField) {
  v1::ClientMessage message;
  const auto none = check_view(message);
  EXPECT_TRUE(none && !*none);
  v1::View& view = *message.mutable_view();
  const auto set = [&](std::array<float, 3> position_m, std::array<float, 3> forward, float half_angle_rad) {
    view.Clear();
    for (const float value : position_m) view.add_position_m(value);
    for (const float value : forward) view.add_forward(value);
    view.set_half_angle_rad(half_angle_rad);
  };
  set({1, 2, 3}, {0, 0.995f, 0}, 0.5f);
  const auto seen = check_view(message);
  ASSERT_TRUE(seen && *seen);
  EXPECT_EQ((*seen)->position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ((*seen)->forward, Eigen::Vector3d(0, 1, 0));
  EXPECT_FLOAT_EQ(static_cast<float>((*seen)->half_angle_rad), 0.5f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refused = [&] {
    const auto taken = check_view(message);
    return taken ? "" : taken.error().message;
  };
  set({1, nan, 3}, {0, 1, 0}, 0.5f);
  EXPECT_EQ(refused(), "view.position_m: must be finite and within 1000 m");
  set({1, 1e9f, 3}, {0, 1, 0}, 0.5f);
  EXPECT_EQ(refused(), "view.position_m: must be finite and within 1000 m");
  set({1, 2, 3}, {0, 0, 0}, 0.5f);
  EXPECT_EQ(refused(), "view.forward: must have length 1");
  set({1, 2, 3}, {0, nan, 1}, 0.5f);
  EXPECT_EQ(refused(), "view.forward: must have length 1");
  for (const float angle_rad : {-0.1f, 4.0f, nan}) {
    set({1, 2, 3}, {0, 1, 0}, angle_rad);
    EXPECT_EQ(refused(), "view.half_angle_rad: must be in 0..pi");
  }
  set({1, 2, 3}, {0, 1, 0}, 0.5f);
  view.add_forward(0);
  EXPECT_EQ(refused(), "view.forward: must have three numbers");
}

TEST(InputCheck, RefusesTooManySamples) {
  v1::ClientMessage message;
  for (int i = 0; i <= kMaxSamplesPerMessage; ++i)
    message.add_inputs()->set_sequence(static_cast<uint64_t>(i) + 1);
  EXPECT_FALSE(check_inputs(message));
}

}  // namespace
}  // namespace livegs

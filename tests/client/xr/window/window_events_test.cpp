// SPDX-License-Identifier: Apache-2.0
#include "xr/window/window_events.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

using Eigen::Vector2d;

constexpr int kKey = 32, kOther = 80, kLeft = 0, kRight = 1;

TEST(WindowEvents, EachPressOfAPictureCountsOnce) {
  WindowEvents events;
  for (int i = 0; i < 10; ++i) {
    events.on_key(kKey, true);
    events.on_key(kKey, false);
  }
  events.on_key(kOther, true);
  EXPECT_EQ(events.presses(kKey), 0);  // of the next picture
  events.begin_picture({0, 0});
  EXPECT_EQ(events.presses(kKey), 10);
  EXPECT_FALSE(events.toggled(kKey));
  EXPECT_TRUE(events.toggled(kOther));
  EXPECT_TRUE(events.held(kKey));  // ImGui sees at least one press
  events.begin_picture({0, 0});
  EXPECT_EQ(events.presses(kKey), 0);
  EXPECT_FALSE(events.held(kKey));
  EXPECT_EQ(events.presses(kOther), 0);  // held since the last picture
  EXPECT_TRUE(events.held(kOther));
}

TEST(WindowEvents, HeldKeyCountsForTheWholePictureAndATapForARefresh) {
  WindowEvents events;
  events.on_key(kKey, true);
  events.begin_picture({0, 0});
  EXPECT_EQ(events.held_share(kKey, 0.5), 1);
  events.on_key(kKey, false);
  events.begin_picture({0, 0});
  EXPECT_EQ(events.held_share(kKey, 0.5), 0);
  for (const bool down : {true, false, true, false}) events.on_key(kKey, down);
  events.begin_picture({0, 0});
  EXPECT_DOUBLE_EQ(events.held_share(kKey, 0.5) * 0.5, 2 * WindowEvents::kTap_s);
  EXPECT_EQ(events.held_share(kKey, 0), 1);
}

TEST(WindowEvents, ClickWithinAPictureIsDownInOneAndUpInTheNext) {
  WindowEvents events;
  const Vector2d at(10, 20), later(300, 40), cursor(500, 600);
  events.on_button(kLeft, true, at);
  events.on_button(kRight, true, at);
  events.on_button(kLeft, false, later);
  events.on_button(kLeft, true, later);
  events.begin_picture(cursor);
  EXPECT_TRUE(events.mouse().down[kLeft] && events.mouse().pressed[kLeft]);
  EXPECT_TRUE(events.mouse().down[kRight]);
  EXPECT_EQ(events.mouse().position_px, at);
  EXPECT_TRUE(events.waiting());
  events.begin_picture(cursor);
  EXPECT_FALSE(events.mouse().down[kLeft]);
  EXPECT_TRUE(events.mouse().held[kLeft]);  // until its release
  EXPECT_EQ(events.mouse().position_px, later);
  EXPECT_TRUE(events.mouse().held[kRight] && !events.mouse().pressed[kRight]);
  events.begin_picture(cursor);
  EXPECT_TRUE(events.mouse().pressed[kLeft]);
  EXPECT_FALSE(events.waiting());
  events.begin_picture(cursor);
  EXPECT_TRUE(events.mouse().down[kLeft] && !events.mouse().pressed[kLeft]);
  EXPECT_EQ(events.mouse().position_px, cursor);
}

TEST(WindowEvents, UnknownButtonsAndRepeatedChangesAreIgnored) {
  WindowEvents events;
  events.on_button(7, true, {1, 1});
  events.on_button(kLeft, false, {1, 1});
  events.on_button(kLeft, true, {2, 2});
  events.on_key(kKey, true);
  events.on_key(kKey, true);
  events.begin_picture({0, 0});
  EXPECT_TRUE(events.mouse().pressed[kLeft]);
  EXPECT_EQ(events.mouse().position_px, Vector2d(2, 2));
  EXPECT_EQ(events.presses(kKey), 1);
}

}  // namespace
}  // namespace livegs

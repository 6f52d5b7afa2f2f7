// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/still_picture.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

using Draw = StillPicture::Draw;
constexpr int64_t kPicture_ns = 20'000'000;

Camera camera() { return look_at({0, 1, 3}, {0, 0, 0}, {0, 1, 0}, 0.8, 320, 200); }

TEST(StillPicture, IsDrawnOnceInFullAfterTheLastChange) {
  StillPicture still;
  int64_t now_ns = 0;
  for (uint64_t version = 1; version <= 5; ++version, now_ns += kPicture_ns) {
    EXPECT_EQ(still.next(camera(), version, now_ns), Draw::Moving);
    EXPECT_FALSE(still.rests());
  }
  int fulls = 0;
  const int64_t changed_ns = now_ns - kPicture_ns;
  for (int i = 0; i < 200; ++i, now_ns += kPicture_ns) {
    const Draw draw = still.next(camera(), 5, now_ns);
    ASSERT_NE(draw, Draw::Moving);
    if (draw != Draw::Full) continue;
    ++fulls;
    EXPECT_LT(now_ns - changed_ns, StillPicture::kRest_ns + kPicture_ns);
  }
  EXPECT_EQ(fulls, 1);
  EXPECT_TRUE(still.rests());
}

TEST(StillPicture, AnyChangeEndsTheRest) {
  const auto rested = [] {
    StillPicture still;
    still.next(camera(), 1, 0);
    EXPECT_EQ(still.next(camera(), 1, StillPicture::kRest_ns), Draw::Full);
    EXPECT_EQ(still.next(camera(), 1, 2 * StillPicture::kRest_ns), Draw::Nothing);
    return still;
  };
  const int64_t later_ns = 3 * StillPicture::kRest_ns;
  Camera moved = camera(), turned = camera(), wide = camera(), zoomed = camera();
  moved.world_from_camera.position_m.x() += 1e-9;
  turned.world_from_camera.orientation.coeffs().x() += 1e-9;
  ++wide.width;
  zoomed.focal_x_px *= 1.001;
  for (const Camera& other : {moved, turned, wide, zoomed})
    EXPECT_EQ(rested().next(other, 1, later_ns), Draw::Moving);
  EXPECT_EQ(rested().next(camera(), 2, later_ns), Draw::Moving);
  StillPicture still = rested();
  still.reset();
  EXPECT_FALSE(still.rests());
  EXPECT_EQ(still.next(camera(), 1, later_ns), Draw::Moving);
}

// A fast renderer draws every picture in full, so rest needs no further one.
TEST(StillPicture, FullPictureIsNotDrawnAgain) {
  StillPicture still;
  EXPECT_EQ(still.next(camera(), 1, 0), Draw::Moving);
  still.drew_in_full();
  EXPECT_EQ(still.next(camera(), 1, StillPicture::kRest_ns), Draw::Nothing);
  EXPECT_TRUE(still.rests());
}

// Waits are short until the picture has rested for a while.
TEST(StillPicture, WaitsLongerAtRest) {
  StillPicture still;
  still.next(camera(), 1, 0);
  const double moving_s = still.wait_s(0);
  still.next(camera(), 1, StillPicture::kRest_ns);
  EXPECT_EQ(still.wait_s(StillPicture::kRest_ns), moving_s);
  EXPECT_GT(still.wait_s(10 * StillPicture::kRest_ns), moving_s);
  EXPECT_LE(moving_s, 1e-9 * StillPicture::kRest_ns);
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
// Object ids and depths of pixels.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "common/splat/synthetic_kernels.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

using synthetic::Object;

constexpr int kWidth = 64, kHeight = 48;

Object disc(double x_m, double z_m, double deviation_m, double opacity, uint32_t id) {
  Object object;
  synthetic::add_ball(object, {x_m, 0, z_m}, deviation_m, opacity, {1, 1, 1});
  object.id = id;
  return object;
}

RasterisedView draw(std::initializer_list<Object> objects) {
  std::vector<DrawnObject> drawn;
  for (const Object& object : objects) drawn.push_back(object.drawn());
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, kWidth, kHeight);
  RasterisedView view;
  Rasteriser().draw(drawn, camera, {}, view);
  return view;
}

size_t middle() { return static_cast<size_t>(kHeight / 2) * kWidth + kWidth / 2; }

TEST(RasteriseObjects, ImageAloneIsTheSameImage) {
  const Object one = synthetic::shell(3000, 2, 0.02, 1);
  Object other = synthetic::moved(one, {{0.3, 0.1, -0.4}, Eigen::Quaterniond(0.8, 0, 0.6, 0)});
  other.id = 1;
  const std::array<DrawnObject, 2> drawn = {one.drawn(), other.drawn()};
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 150, 100);
  RasteriseOptions options;
  RasterisedView all, image;
  Rasteriser rasteriser;
  rasteriser.draw(drawn, camera, options, all);
  options.image_only = true;
  rasteriser.draw(drawn, camera, options, image);
  EXPECT_EQ(image.image.pixels, all.image.pixels);
  EXPECT_TRUE(image.depth_m.empty() && image.object_id.empty());
  EXPECT_EQ(all.object_id.size(), 150u * 100u);
}

TEST(RasteriseObjects, AnEmptySceneIsBackground) {
  RasteriseOptions options;
  options.background = {0.1f, 0.2f, 0.3f};
  RasterisedView view;
  Rasteriser().draw({}, look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, kWidth, kHeight),
                    options, view);
  EXPECT_EQ(view.image.at(3, 3)[0], 0.1f);
  EXPECT_EQ(view.image.at(3, 3)[3], 0.0f);
  EXPECT_EQ(view.object_id[middle()], kNoObject);
  EXPECT_EQ(view.depth_m[middle()], std::numeric_limits<float>::infinity());
}

TEST(RasteriseObjects, TheFrontObjectOwnsThePixel) {
  const RasterisedView view = draw({disc(0, -1, 0.5, 0.95, 7), disc(0, 0, 0.5, 0.95, 3)});
  EXPECT_EQ(view.object_id[middle()], 3u);
  EXPECT_NEAR(view.depth_m[middle()], 2.0f, 1e-6f);
}

// An object behind a thin veil has the larger share.
TEST(RasteriseObjects, AVeilIsNotTheOwner) {
  const RasterisedView view = draw({disc(0, 0, 0.5, 0.3, 3), disc(0, -1, 0.8, 0.95, 7)});
  EXPECT_EQ(view.object_id[middle()], 7u);
  EXPECT_NEAR(view.depth_m[middle()], 3.0f, 1e-6f);
}

// Three faint layers of one object together outweigh one stronger layer of another.
TEST(RasteriseObjects, SharesOfOneObjectAddUp) {
  Object layered;
  for (int i = 0; i < 3; ++i) synthetic::add_ball(layered, {0, 0, -0.1 * i}, 0.5, 0.25, {1, 1, 1});
  layered.id = 5;
  const RasterisedView view = draw({disc(0, -1, 0.8, 0.9, 6), layered});
  EXPECT_EQ(view.object_id[middle()], 5u);  // 0.578 compared with 0.38
}

TEST(RasteriseObjects, EqualIdsAreOneObject) {
  const RasterisedView view =
      draw({disc(0, 0, 0.5, 0.3, 5), disc(0, -0.1, 0.5, 0.3, 5), disc(0, -1, 0.8, 0.9, 6)});
  EXPECT_EQ(view.object_id[middle()], 5u);  // 0.3 + 0.21 compared with 0.44
}

TEST(RasteriseObjects, LowCoverageHasNoObject) {
  const RasterisedView view = draw({disc(0, 0, 0.5, 0.3, 3), disc(0, -1, 0.5, 0.2, 4)});
  EXPECT_EQ(view.object_id[middle()], kNoObject);
  EXPECT_EQ(view.depth_m[middle()], std::numeric_limits<float>::infinity());
}

TEST(RasteriseObjects, ASingleObjectOwnsItsCoverage) {
  const RasterisedView view = draw({disc(0, 0, 0.1, 0.9, 12)});
  EXPECT_EQ(view.object_id[middle()], 12u);
  EXPECT_EQ(view.object_id[0], kNoObject);
}

// The mask of a disc has the area of the disc: alpha falls to 0.5 at radius sigma sqrt(2 ln(opacity / 0.5)).
TEST(RasteriseObjects, TheMaskHasTheAreaOfTheDisc) {
  const RasterisedView view = draw({disc(-0.2, 0, 0.15, 0.9, 1), disc(0.9, 0, 0.01, 0.9, 2)});
  size_t area = 0;
  for (const uint32_t id : view.object_id) area += id == 1;
  const double focal_px = 0.5 * kHeight / std::tan(0.4);
  const double variance_px2 = std::pow(0.15 * focal_px / 2.0, 2) + 0.3;
  const double expected = M_PI * variance_px2 * 2.0 * std::log(0.9 / 0.5);
  EXPECT_NEAR(static_cast<double>(area), expected, 0.1 * expected);  // pixels along a rim of radius 17 px
}

}  // namespace
}  // namespace livegs

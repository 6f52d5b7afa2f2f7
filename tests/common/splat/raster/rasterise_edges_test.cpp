// SPDX-License-Identifier: Apache-2.0
// Kernels and cameras at the limits of projection. Several cases are defects found in other renderers.
#include <gtest/gtest.h>

#include <cmath>

#include "common/splat/synthetic_kernels.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

using synthetic::Object;

constexpr double kRounding = 3e-6;  // floats of order 1 after a dozen roundings

RasterisedView draw(const Object& object, const Camera& camera) {
  const DrawnObject drawn = object.drawn();
  RasterisedView view;
  Rasteriser().draw({&drawn, 1}, camera, {}, view);
  return view;
}

Camera ahead(int width = 128, int height = 96) {
  return look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, width, height);
}

bool all_finite(const Image& image) {
  for (const float value : image.pixels) {
    if (!std::isfinite(value) || value < 0.0f) return false;
  }
  return true;
}

TEST(RasteriseEdges, APointKernelHasTheLowPassSize) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 1.0, 0.8, {1, 1, 1});
  object.posed.covariances_m2[0] = {};
  Camera camera = ahead();
  camera.centre_x_px += 0.5;
  camera.centre_y_px += 0.5;
  const RasterisedView view = draw(object, camera);
  EXPECT_NEAR(view.image.at(64, 48)[3], 0.8, kRounding);
  EXPECT_NEAR(view.image.at(65, 48)[3], 0.8 * std::exp(-0.5 / 0.3), kRounding);
  EXPECT_EQ(view.image.at(67, 48)[3], 0.0f);
}

TEST(RasteriseEdges, AHugeKernelCoversTheScreen) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 1000.0, 0.8, {1, 1, 1});
  const RasterisedView view = draw(object, ahead());
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x)
      ASSERT_NEAR(view.image.at(x, y)[3], 0.8, 1e-5) << x << " " << y;  // 1e-7 of sigma²
  }
}

TEST(RasteriseEdges, AnEdgeOnSheetIsALine) {
  Object object;
  synthetic::add_kernel(object, {0, 0, 0}, Eigen::Quaterniond::Identity(), {0.2, 1e-7, 0.2}, 0.8, {1, 1, 1});
  const RasterisedView view = draw(object, ahead());
  EXPECT_TRUE(all_finite(view.image));
  EXPECT_GT(view.image.at(64, 47)[3], 0.3f);  // the low-pass spreads half a pixel to both sides
  EXPECT_LT(view.image.at(64, 40)[3], 0.01f);
}

TEST(RasteriseEdges, KernelsBehindAreInvisible) {
  Object object;
  synthetic::Random random(3);
  for (int i = 0; i < 500; ++i) {
    synthetic::add_ball(object, random.in_ball(1.0) + Eigen::Vector3d(0, 0, 3.0), random.uniform(0.01, 0.5),
                        0.9, {1, 1, 1});
  }
  const RasterisedView view = draw(object, ahead());
  for (size_t i = 3; i < view.image.pixels.size(); i += 4) ASSERT_EQ(view.image.pixels[i], 0.0f);
}

// Close to the near plane and far off the axis: without the Jacobian clamp, the ellipse would be kilometres
// long.
TEST(RasteriseEdges, AKernelNextToTheEyeDoesNotSmear) {
  Object object;
  synthetic::add_ball(object, {1.5, 0, 1.9}, 0.02, 0.9, {1, 1, 1});
  const RasterisedView view = draw(object, ahead());
  for (size_t i = 3; i < view.image.pixels.size(); i += 4) ASSERT_EQ(view.image.pixels[i], 0.0f);
}

TEST(RasteriseEdges, MovingThroughKernelsStaysFinite) {
  const Object object = synthetic::shell(3000, 3, 0.05, 4);
  for (int i = 0; i < 24; ++i) {
    const double z = 0.9 - 0.08 * i;
    const Camera camera = look_at({0.01, 0.02, z}, {0, 0, z - 1.0}, Eigen::Vector3d::UnitY(), 2.4, 100, 70);
    EXPECT_TRUE(all_finite(draw(object, camera).image)) << z;
  }
}

TEST(RasteriseEdges, ExtremeFiniteValuesStayFinite) {
  Object object;
  for (const float position : {0.0f, 1e-30f, 1e10f, -1e18f}) {
    for (const float variance : {0.0f, 1e-38f, 1e10f, 1e37f}) {
      synthetic::add_ball(object, {0, 0, 0}, 1.0, 0.9, {1, 1, 1});
      object.posed.positions_m.back() = {position, -position, -std::abs(position)};
      object.posed.covariances_m2.back() = {variance, 0, 0, variance, 0, variance};
    }
  }
  EXPECT_TRUE(all_finite(draw(object, ahead()).image));
}

TEST(RasteriseEdges, AnyImageSizeIsDrawnToItsEdge) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 1e5, 0.8, {1, 1, 1});
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {8, 16}, {16, 16}, {17, 33}, {250, 1}}) {
    const RasterisedView view = draw(object, ahead(width, height));
    ASSERT_EQ(view.image.pixels.size(), 4u * width * height);
    EXPECT_NEAR(view.image.at(0, 0)[3], 0.8, 1e-5);
    EXPECT_NEAR(view.image.at(width - 1, height - 1)[3], 0.8, 1e-5);
  }
}

}  // namespace
}  // namespace livegs

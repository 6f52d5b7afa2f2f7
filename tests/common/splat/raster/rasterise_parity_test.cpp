// SPDX-License-Identifier: Apache-2.0
// Compares the rasteriser with a brute-force renderer in doubles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/splat/raster/reference_renderer.h"
#include "common/splat/synthetic_kernels.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

using synthetic::Object;

// Rounding may move one kernel across the threshold at a pixel: 1/255 of a colour below 2 in these scenes.
constexpr double kCutOffStep = 2.0 / 255.0;
// The mean error, unlike the step, is only float rounding.
constexpr double kMinPsnr_db = 60.0;

double max_difference(const Image& a, const Image& b) {
  double worst = 0.0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    worst = std::max(worst, std::abs(static_cast<double>(a.pixels[i]) - b.pixels[i]));
  }
  return worst;
}

void expect_equal_to_reference(std::span<const DrawnObject> objects, const Camera& camera,
                               const RasteriseOptions& options = {}) {
  RasterisedView view;
  Rasteriser().draw(objects, camera, options, view);
  const Image expected = ReferenceRenderer(objects, camera, options).image();
  const double psnr = psnr_db(view.image, expected), worst = max_difference(view.image, expected);
  EXPECT_GE(psnr, kMinPsnr_db);
  EXPECT_LE(worst, kCutOffStep);
  ::testing::Test::RecordProperty("psnr_db", std::to_string(psnr));
  ::testing::Test::RecordProperty("max_difference", std::to_string(worst));
}

void expect_equal_to_reference(const Object& object, const Camera& camera,
                               const RasteriseOptions& options = {}) {
  const DrawnObject drawn = object.drawn();
  expect_equal_to_reference({&drawn, 1}, camera, options);
}

Camera in_front(double distance_m = 1.6) {
  return look_at({0.3, 0.4, distance_m}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY(), 0.8, 97, 75);
}

TEST(RasteriseParity, EachShDegree) {
  for (int degree = 0; degree <= 3; ++degree) {
    expect_equal_to_reference(synthetic::shell(1000, degree, 0.02, 3 + degree), in_front());
  }
}

TEST(RasteriseParity, LowerDegreeThanTheAsset) {
  RasteriseOptions options;
  options.max_sh_degree = 1;
  options.background = {0.2f, 0.7f, 1.0f};
  expect_equal_to_reference(synthetic::shell(1000, 3, 0.02, 8), in_front(), options);
}

TEST(RasteriseParity, DistanceOrder) {
  RasteriseOptions options;
  options.order = DepthOrder::Distance;
  expect_equal_to_reference(synthetic::shell(1000, 1, 0.03, 9), in_front(), options);
}

TEST(RasteriseParity, MipTrainedKernels) {
  Object object = synthetic::shell(1000, 0, 0.006, 10);
  object.asset.antialiased = true;
  expect_equal_to_reference(object, in_front());
}

TEST(RasteriseParity, CameraInsideTheObject) {
  const Camera camera = look_at({0.05, 0.0, 0.1}, {0.4, 0.1, -1.0}, Eigen::Vector3d::UnitY(), 1.6, 97, 75);
  expect_equal_to_reference(synthetic::shell(1000, 2, 0.03, 11), camera);
}

TEST(RasteriseParity, CameraTouchingKernels) {
  const Camera camera = look_at({0.0, 0.0, 0.62}, {0.0, 0.0, 0.0}, Eigen::Vector3d::UnitY(), 1.2, 97, 75);
  expect_equal_to_reference(synthetic::shell(1000, 0, 0.03, 12), camera);
}

// The limits of the Jacobian differ between the sides; a symmetric form would be wrong at both edges.
TEST(RasteriseParity, AsymmetricFrustum) {
  const Pose pose =
      look_at({0.2, 0.1, 0.75}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY(), 1, 1, 1).world_from_camera;
  const Camera camera = camera_from_fov(pose, -0.95, 0.6, 0.7, -0.9, 97, 75);
  expect_equal_to_reference(synthetic::shell(1000, 1, 0.04, 13), camera);
}

// Axis-aligned ellipses have no off-diagonal entry; code that derives axes from it divides by zero.
TEST(RasteriseParity, AxisAlignedKernels) {
  Object object;
  const Eigen::Quaterniond straight = Eigen::Quaterniond::Identity();
  synthetic::add_kernel(object, {-0.3, 0.2, 0}, straight, {0.1, 0.02, 0.01}, 0.9, {1, 0, 0});
  synthetic::add_kernel(object, {0.3, 0.2, 0}, straight, {0.02, 0.1, 0.01}, 0.9, {0, 1, 0});
  synthetic::add_kernel(object, {0.0, -0.2, 0}, straight, {0.06, 0.06, 0.06}, 0.9, {0, 0, 1});
  const Camera camera = look_at({0, 0, 1.5}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY(), 0.8, 97, 75);
  expect_equal_to_reference(object, camera);
}

// Standard deviation 300 px, and narrower than the low-pass: in floats, the terms of the conic cancel to 1e-6
// of their size. Longer needles lose their width in the float covariance itself.
TEST(RasteriseParity, DiagonalNeedles) {
  Object object;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.37 * i + 0.1, Eigen::Vector3d::UnitZ()));
    synthetic::add_kernel(object, {0.05 * i - 0.2, 0.0, -0.01 * i}, turn, {5.0, 1e-4, 1e-4}, 0.7,
                          {0.1 * i, 1.0 - 0.1 * i, 0.5});
  }
  const Camera camera = look_at({0, 0, 1.5}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY(), 0.8, 97, 75);
  expect_equal_to_reference(object, camera);
}

TEST(RasteriseParity, KernelsAcrossTheWholeScreen) {
  Object object;
  synthetic::Random random(14);
  for (int i = 0; i < 300; ++i) {
    synthetic::add_kernel(object, random.in_ball(2.0) - Eigen::Vector3d(0, 0, 3), random.rotation(),
                          {random.uniform(0.1, 4.0), random.uniform(0.1, 4.0), random.uniform(0.1, 4.0)}, 0.1,
                          {random.uniform(), random.uniform(), random.uniform()});
  }
  const Camera camera = look_at({0, 0, 1.5}, {0, 0, -1}, Eigen::Vector3d::UnitY(), 0.8, 97, 75);
  expect_equal_to_reference(object, camera);
}

TEST(RasteriseParity, InterpenetratingObjects) {
  const Object a = synthetic::shell(700, 1, 0.03, 15);
  Object b = synthetic::moved(synthetic::shell(700, 3, 0.02, 16),
                              {{0.2, 0.1, 0.1}, Eigen::Quaterniond(0.3, 0.8, -0.4, 0.2).normalized()});
  b.id = 1;
  const DrawnObject drawn[] = {a.drawn(), b.drawn()};
  expect_equal_to_reference(drawn, in_front());
}

// Many more tiles than one batch of bins, so that tiles keep their state between batches. The reference
// evaluates only a few pixels.
TEST(RasteriseParity, ManyBatches) {
  Object object;
  synthetic::Random random(17);
  for (int i = 0; i < 12'000; ++i) {
    synthetic::add_ball(object, random.in_ball(0.3), 0.5, 0.006,
                        {random.uniform(), random.uniform(), random.uniform()});
  }
  // Small bright kernels in front of and behind the haze must keep their depth order.
  for (int i = 0; i < 200; ++i) synthetic::add_ball(object, random.in_ball(0.6), 0.01, 0.5, {0.9, 0.1, 0.1});
  const Camera camera = look_at({0, 0, 2}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY(), 0.8, 400, 300);
  const DrawnObject drawn = object.drawn();
  RasterisedView view;
  Rasteriser().draw({&drawn, 1}, camera, {}, view);
  const ReferenceRenderer reference({&drawn, 1}, camera, {});
  for (int i = 0; i < 300; ++i) {
    const int x = static_cast<int>(random.uniform(0, 400)), y = static_cast<int>(random.uniform(0, 300));
    const ReferenceRenderer::Pixel expected = reference.pixel(x, y);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(view.image.at(x, y)[c], expected.rgb[c], kCutOffStep) << x << " " << y;
    const float depth_m = view.depth_m[static_cast<size_t>(y) * 400 + x];
    EXPECT_EQ(std::isinf(depth_m), std::isinf(expected.depth_m));
    // Where transmittance passes 0.5, rounding may select a neighbour in depth; neighbours are 0.6 m / 12,000
    // apart.
    if (!std::isinf(depth_m)) {
      EXPECT_NEAR(depth_m, expected.depth_m, 0.001);
    }
  }
}

TEST(RasteriseParity, Depth) {
  const Object object = synthetic::shell(1000, 0, 0.03, 18);
  const DrawnObject drawn = object.drawn();
  const Camera camera = in_front();
  RasterisedView view;
  Rasteriser().draw({&drawn, 1}, camera, {}, view);
  const ReferenceRenderer reference({&drawn, 1}, camera, {});
  int different = 0, finite = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double expected = reference.pixel(x, y).depth_m;
      const float depth = view.depth_m[static_cast<size_t>(y) * camera.width + x];
      if (std::isinf(expected) && std::isinf(depth)) continue;
      ++finite;
      different += !(std::abs(depth - expected) < 1e-5);  // floats near 2 m
    }
  }
  EXPECT_GT(finite, 1000);
  EXPECT_LE(different, finite / 1000);  // pixels with a transmittance of 0.5 up to rounding
}

}  // namespace
}  // namespace livegs

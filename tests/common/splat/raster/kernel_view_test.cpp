// SPDX-License-Identifier: Apache-2.0
#include "splat/kernel_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/splat/synthetic_kernels.h"
#include "core/parallel_for.h"
#include "splat/rasterise.h"

namespace livegs {
namespace {

Camera front_camera(int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.focal_x_px = camera.focal_y_px = width;
  camera.centre_x_px = 0.5 * width;
  camera.centre_y_px = 0.5 * height;
  return camera;
}

// A wide flat kernel that is tilted about the x axis.
TEST(KernelView, DepthIsWhereTheRayMeetsAFlatKernel) {
  synthetic::Object object;
  const double tilt = 0.6;
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()));
  const Eigen::Vector3d middle(0, 0, -2);
  synthetic::add_kernel(object, middle, rotation, {0.5, 0.5, 1e-4}, 0.95, {1, 0, 0});
  const Camera camera = front_camera(64, 48);
  KernelRasteriser rasteriser;
  KernelView view;
  rasteriser.draw(object.drawn(), camera, view);
  const Eigen::Vector3d normal = rotation * Eigen::Vector3d::UnitZ();
  size_t seen = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const size_t pixel = static_cast<size_t>(y) * 64 + x;
      if (view.kernel[pixel] == kNoKernel) {
        EXPECT_TRUE(std::isinf(view.depth_m[pixel]));
        continue;
      }
      ++seen;
      const Eigen::Vector3d ray((x + 0.5 - 32) / 64, -(y + 0.5 - 24) / 64, -1);
      const double expected_m = normal.dot(middle) / normal.dot(ray);
      // The floor of a twentieth of a pixel, 1.6 mm at 2 m, tilts the plane by (1.6 mm / 0.5 m)² of the
      // offset.
      EXPECT_NEAR(view.depth_m[pixel], expected_m, 1e-4) << x << ", " << y;
    }
  EXPECT_GT(seen, 300u);
}

// For one kernel along the ray t, exp(-(t - m)² / 2 s²) is largest at its mean.
TEST(KernelView, GreatestResponseOfARoundKernelIsNearestToItsMean) {
  const Eigen::Vector3d mean(0.3, -0.2, 2.0), ray(0.1, 0.05, 1.0);
  const double depth_m = greatest_response_depth_m(mean, 0.01 * Eigen::Matrix3d::Identity(), ray, 0.0);
  EXPECT_NEAR(depth_m, ray.dot(mean) / ray.squaredNorm(), 1e-12);
}

TEST(KernelView, ImageEqualsTheRasteriser) {
  const synthetic::Object object = synthetic::shell(3000, 1, 0.02, 5);
  Camera camera = front_camera(100, 75);
  camera.world_from_camera.position_m = {0, 0, 1.5};
  KernelRasteriser kernels;
  KernelView view;
  kernels.draw(object.drawn(), camera, view);
  Rasteriser rasteriser;
  RasterisedView expected;
  const DrawnObject drawn = object.drawn();
  rasteriser.draw(std::span(&drawn, 1), camera, {}, expected);
  EXPECT_EQ(view.image.pixels, expected.image.pixels);
}

// The weights of all kernels of a pixel add up to its coverage, whatever the labels.
TEST(KernelView, WeightsAddUpToTheCoverageOfEachLabel) {
  const synthetic::Object object = synthetic::shell(2000, 0, 0.03, 6);
  Camera camera = front_camera(70, 50);
  camera.world_from_camera.position_m = {0, 0, 1.5};
  std::vector<uint16_t> labels(70 * 50);
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 70; ++x)
      labels[static_cast<size_t>(y) * 70 + x] = static_cast<uint16_t>(x / 9 % 3 * 300);
  KernelRasteriser kernels;
  KernelView view;
  kernels.draw(object.drawn(), camera, view);
  std::vector<LabelWeight> weights;
  kernels.weigh(object.drawn(), camera, labels, weights);
  double sums[3] = {}, expected[3] = {};
  for (const LabelWeight& w : weights) {
    ASSERT_LT(w.kernel, object.size());
    ASSERT_EQ(w.label % 300, 0u);
    sums[w.label / 300] += w.weight;
  }
  for (size_t i = 0; i < labels.size(); ++i) expected[labels[i] / 300] += view.image.pixels[4 * i + 3];
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(sums[i], expected[i], 1e-4 * expected[i]) << i;  // rounding of floats
}

TEST(KernelView, SameBitsForAnyThreadCount) {
  const synthetic::Object object = synthetic::shell(3000, 0, 0.02, 7);
  Camera camera = front_camera(90, 70);
  camera.world_from_camera.position_m = {0, 0, 1.5};
  const std::vector<uint16_t> labels(90 * 70, 3);
  KernelView first;
  std::vector<LabelWeight> first_weights;
  for (int threads : {1, 2, 8}) {
    set_thread_count(threads);
    KernelRasteriser kernels;
    KernelView view;
    std::vector<LabelWeight> weights;
    kernels.draw(object.drawn(), camera, view);
    kernels.weigh(object.drawn(), camera, labels, weights);
    if (threads == 1) first = view, first_weights = weights;
    EXPECT_EQ(view.kernel, first.kernel);
    EXPECT_EQ(view.depth_m, first.depth_m);
    ASSERT_EQ(weights.size(), first_weights.size());
    for (size_t i = 0; i < weights.size(); ++i) {
      EXPECT_EQ(weights[i].kernel, first_weights[i].kernel);
      EXPECT_EQ(weights[i].weight, first_weights[i].weight);
    }
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "render/surface_near.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/splat/synthetic_kernels.h"

namespace livegs {
namespace {

const Eigen::AlignedBox3f kAll(Eigen::Vector3f::Constant(-10), Eigen::Vector3f::Constant(10));

// One standard deviation of a rotated ellipsoid with known axes.
TEST(SurfaceNear, SurfaceIsAtOneStandardDeviation) {
  synthetic::Object object;
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  synthetic::add_kernel(object, {1, 0, 0}, quarter, {0.3, 0.1, 0.05}, 0.9, {1, 1, 1});
  const DrawnObject drawn = object.drawn();
  const auto surface = surface_within({&drawn, 1}, kAll, 10);
  ASSERT_EQ(surface.size(), 1u);
  EXPECT_NEAR(distance_to_surface(surface, {1, 1, 0}), 0.7, 1e-5);  // long axis
  EXPECT_NEAR(distance_to_surface(surface, {2, 0, 0}), 0.9, 1e-5);
  EXPECT_NEAR(distance_to_surface(surface, {1, 0, 2}), 1.95, 1e-5);
  EXPECT_LT(distance_to_surface(surface, {1, 0.2f, 0}), 0.0f);
  EXPECT_EQ(distance_to_surface({}, {1, 0, 0}), std::numeric_limits<float>::infinity());
}

TEST(SurfaceNear, UsesLimitedOpaqueKernelsInBox) {
  synthetic::Object object;
  object.id = 5;
  for (int i = 0; i < 100; ++i)
    synthetic::add_ball(object, {0.01 * i, 0, 0}, 0.01, i % 2 ? 0.9 : 0.3, {1, 1, 1});
  const DrawnObject drawn = object.drawn();
  EXPECT_EQ(surface_within({&drawn, 1}, kAll, 1000).size(), 50u);
  const auto some =
      surface_within({&drawn, 1}, {Eigen::Vector3f(-1, -1, -1), Eigen::Vector3f(0.495f, 1, 1)}, 5);
  ASSERT_EQ(some.size(), 5u);
  for (const SurfaceKernel& kernel : some) {
    EXPECT_EQ(kernel.object_id, 5u);
    EXPECT_LT(kernel.middle_m.x(), 0.5f);
  }
}

}  // namespace
}  // namespace livegs

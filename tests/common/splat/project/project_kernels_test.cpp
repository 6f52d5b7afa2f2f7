// SPDX-License-Identifier: Apache-2.0
#include "splat/project/project_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/splat/synthetic_kernels.h"

namespace livegs {
namespace {

using synthetic::Object;

Camera ahead() { return look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.8, 320, 240); }

bool is_seen(const Object& object, const Camera& camera = ahead(), const RasteriseOptions& options = {}) {
  ProjectedKernel projected;
  float depth_m;
  return project_kernel(Projection(camera), object.drawn(), 0, 0, options, projected, depth_m);
}

Object ball(const Eigen::Vector3d& position_m, double standard_deviation_m = 0.05) {
  Object object;
  synthetic::add_ball(object, position_m, standard_deviation_m, 0.9, {1, 1, 1});
  return object;
}

TEST(ProjectKernels, CullsKernelsBehindTheCamera) {
  EXPECT_TRUE(is_seen(ball({0, 0, 0})));
  EXPECT_FALSE(is_seen(ball({0, 0, 3})));
  EXPECT_FALSE(is_seen(ball({0, 0, 2})));      // in the eye
  EXPECT_FALSE(is_seen(ball({0, 0, 1.951})));  // nearer than near_m
  EXPECT_FALSE(is_seen(ball({5, 0, 2.5}, 3.0)));
}

// Visibility depends on the ellipse, not the centre; otherwise wide kernels vanish at the edge of the screen.
TEST(ProjectKernels, KeepsEllipsesThatReachIntoTheScreen) {
  EXPECT_TRUE(is_seen(ball({1.4, 0, 0}, 0.2)));
  EXPECT_FALSE(is_seen(ball({1.4, 0, 0}, 0.01)));
}

TEST(ProjectKernels, CullsFaintKernels) {
  Object object;
  synthetic::add_ball(object, {0, 0, 0}, 0.05, 0.9 / 255.0, {1, 1, 1});
  EXPECT_FALSE(is_seen(object));
}

TEST(ProjectKernels, CullsNonFiniteValues) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    for (int i = 0; i < 3; ++i) {
      Object object = ball({0, 0, 0});
      object.posed.positions_m[0][i] = bad;
      EXPECT_FALSE(is_seen(object)) << "position " << i << " " << bad;
    }
    for (int i = 0; i < 6; ++i) {
      Object object = ball({0, 0, 0});
      object.posed.covariances_m2[0][i] = bad;
      EXPECT_FALSE(is_seen(object)) << "covariance " << i << " " << bad;
    }
  }
  Object object = ball({0, 0, 0});
  object.asset.opacity_logits[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(is_seen(object));
  object.asset.opacity_logits[0] = -std::numeric_limits<float>::infinity();
  EXPECT_FALSE(is_seen(object));
  object.asset.opacity_logits[0] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(is_seen(object));
}

// Not a valid covariance: the determinant of the sum is negative, so there is no ellipse.
TEST(ProjectKernels, CullsNegativeVariance) {
  Object object = ball({0, 0, 0});
  object.posed.covariances_m2[0] = {-1, 0, 0, 1, 0, 1};
  EXPECT_FALSE(is_seen(object));
}

TEST(ProjectKernels, SupportsBothDepthOrders) {
  const Object object = ball({0.5, 0, 0});
  ProjectedKernel projected;
  float depth_m = 0;
  RasteriseOptions options;
  ASSERT_TRUE(project_kernel(Projection(ahead()), object.drawn(), 0, 0, options, projected, depth_m));
  EXPECT_FLOAT_EQ(depth_m, 2.0f);
  options.order = DepthOrder::Distance;
  ASSERT_TRUE(project_kernel(Projection(ahead()), object.drawn(), 0, 0, options, projected, depth_m));
  EXPECT_FLOAT_EQ(depth_m, std::sqrt(4.25f));
  EXPECT_FLOAT_EQ(projected.depth_m, 2.0f);
}

}  // namespace
}  // namespace livegs

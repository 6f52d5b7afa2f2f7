// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/orbit_camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "viewer/camera/render_scale.h"

namespace livegs {
namespace {

Camera start() { return look_at({1, 2, 3}, {0, 0.5, 0}, Eigen::Vector3d::UnitY(), 0.7, 800, 600); }
double distance() { return (Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(0, 0.5, 0)).norm(); }

TEST(OrbitCamera, StartsAtGivenCamera) {
  const Camera camera = OrbitCamera(start(), distance()).camera(800, 600);
  EXPECT_LT((camera.world_from_camera.position_m - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT(camera.world_from_camera.orientation.angularDistance(start().world_from_camera.orientation),
            1e-9);
  EXPECT_NEAR(camera.focal_y_px, start().focal_y_px, 1e-9);
}

TEST(OrbitCamera, OrbitStopsAtPoles) {
  OrbitCamera orbit(start(), distance());
  orbit.orbit({600, 0}, 600);  // half a turn: the opposite side of the target
  const Eigen::Vector3d other = orbit.camera(800, 600).world_from_camera.position_m;
  EXPECT_LT((other - Eigen::Vector3d(-1, 2, -3)).norm(), 1e-9);
  for (int i = 0; i < 10; ++i) orbit.orbit({0, 600}, 600);
  const Camera above = orbit.camera(800, 600);
  EXPECT_NEAR((above.world_from_camera.position_m - orbit.target_m()).norm(), distance(), 1e-9);
  EXPECT_GT((above.world_from_camera.orientation * Eigen::Vector3d::UnitY()).y(), 0.0);
}

// Moves the target distance per second along its axes with a constant direction; a long pause counts as at
// most a tenth of a second.
TEST(OrbitCamera, FliesAlongAxesWithFixedDirection) {
  OrbitCamera orbit(start(), distance());
  const Pose before = orbit.camera(800, 600).world_from_camera;
  for (int i = 0; i < 10; ++i) orbit.fly({0, 0, -1}, 0.05);
  const Pose ahead = orbit.camera(800, 600).world_from_camera;
  EXPECT_LT((ahead.position_m - before * Eigen::Vector3d(0, 0, -0.5 * distance())).norm(), 1e-9);
  EXPECT_LT(ahead.orientation.angularDistance(before.orientation), 1e-9);
  orbit.fly({1, 1, 0}, 30);
  const Pose aside = orbit.camera(800, 600).world_from_camera;
  EXPECT_LT((aside.position_m - ahead * Eigen::Vector3d(0.1 * distance(), 0.1 * distance(), 0)).norm(), 1e-9);
}

// A point at the target's distance stays under the mouse.
TEST(OrbitCamera, PanFollowsMouse) {
  OrbitCamera orbit(start(), distance());
  const Eigen::Vector3d point = orbit.target_m();
  orbit.pan({120, -45}, 600);
  const auto seen = pixel_of(orbit.camera(800, 600), point);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 400 + 120, 1e-6);
  EXPECT_NEAR(seen->y(), 300 - 45, 1e-6);
}

TEST(OrbitCamera, ZoomStopsBeforeTarget) {
  OrbitCamera orbit(start(), distance());
  orbit.zoom(2);
  EXPECT_NEAR((orbit.camera(800, 600).world_from_camera.position_m - orbit.target_m()).norm(),
              0.81 * distance(), 1e-9);
  orbit.zoom(1000);
  EXPECT_GT((orbit.camera(800, 600).world_from_camera.position_m - orbit.target_m()).norm(), 0.04);
}

TEST(OrbitCamera, PixelRayHitsProjectedPoint) {
  const Camera camera = start();
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(400, 300), {13, 570}, {799, 2}}) {
    const Pose ray = ray_through(camera, pixel);
    const auto seen = pixel_of(camera, ray * Eigen::Vector3d(0, 0, -1.7));
    ASSERT_TRUE(seen);
    EXPECT_LT((*seen - pixel).norm(), 1e-6);
  }
  EXPECT_FALSE(pixel_of(camera, camera.world_from_camera * Eigen::Vector3d(0, 0, 1)));
}

// With a cost proportional to the pixels, the size settles within the budget.
TEST(RenderScale, SettlesWithinBudget) {
  for (const double full_ms : {5.0, 60.0, 200.0, 10'000.0}) {
    RenderScale scale(30);
    const auto ms = [&] { return full_ms * scale.value() * scale.value(); };
    for (int i = 0; i < 50; ++i) scale.drew(ms());
    if (full_ms < 400) {
      EXPECT_LE(ms(), 30.0) << full_ms;
    }
    EXPECT_EQ(scale.value() == 1.0, full_ms <= 5.0);
    EXPECT_EQ(scale.value() == 0.25, full_ms >= 10'000);
    const double settled = scale.value();
    for (int i = 0; i < 20; ++i) {
      scale.drew(ms());
      EXPECT_EQ(scale.value(), settled) << full_ms;
    }
  }
}

}  // namespace
}  // namespace livegs

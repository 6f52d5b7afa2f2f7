// SPDX-License-Identifier: Apache-2.0
#include "splat/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "splat/frame_bounds.h"
#include "splat/project/project_kernels.h"

namespace livegs {
namespace {

constexpr double kRounding = 1e-9;  // doubles of about a thousand pixels

// Projection of a point by the documented conventions of Camera.
Eigen::Vector2d pixel_of(const Camera& camera, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d p = camera.world_from_camera.inverse() * point_m;
  return {camera.centre_x_px + camera.focal_x_px * p.x() / -p.z(),
          camera.centre_y_px - camera.focal_y_px * p.y() / -p.z()};
}

TEST(Camera, LookAtCentresTheTarget) {
  const Camera camera = look_at({1, 2, 3}, {-1, 0, 0.5}, Eigen::Vector3d::UnitY(), 0.9, 640, 480);
  EXPECT_LT((pixel_of(camera, {-1, 0, 0.5}) - Eigen::Vector2d(320, 240)).norm(), kRounding);
}

TEST(Camera, UpAndRightHaveTheRightSigns) {
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.9, 640, 480);
  EXPECT_LT(pixel_of(camera, {0, 0.1, 0}).y(), 240);
  EXPECT_GT(pixel_of(camera, {0.1, 0, 0}).x(), 320);
}

TEST(Camera, FieldOfViewSpansTheImage) {
  const double fov = 0.9;
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY(), fov, 640, 480);
  EXPECT_NEAR(pixel_of(camera, {0, 2 * std::tan(0.5 * fov), 0}).y(), 0.0, kRounding);
  EXPECT_NEAR(pixel_of(camera, {0, -2 * std::tan(0.5 * fov), 0}).y(), 480.0, kRounding);
}

TEST(Camera, LookingStraightDownIsValid) {
  const Camera camera = look_at({0, 2, 0}, {0, 0, 0}, Eigen::Vector3d::UnitY(), 0.9, 640, 480);
  EXPECT_NEAR(camera.world_from_camera.orientation.norm(), 1.0, kRounding);
  EXPECT_LT((pixel_of(camera, {0, 0, 0}) - Eigen::Vector2d(320, 240)).norm(), kRounding);
}

TEST(Camera, ASymmetricFovEqualsLookAt) {
  const double vertical = 0.9;
  const double half = 0.5 * vertical, across = std::atan(std::tan(half) * 640.0 / 480.0);
  const Camera expected = look_at({1, 2, 3}, {0, 0, 0}, Eigen::Vector3d::UnitY(), vertical, 640, 480);
  const Camera camera = camera_from_fov(expected.world_from_camera, -across, across, half, -half, 640, 480);
  EXPECT_NEAR(camera.focal_x_px, expected.focal_x_px, kRounding);
  EXPECT_NEAR(camera.focal_y_px, expected.focal_y_px, kRounding);
  EXPECT_NEAR(camera.centre_x_px, 320, kRounding);
  EXPECT_NEAR(camera.centre_y_px, 240, kRounding);
}

TEST(Camera, AnAsymmetricFovHasTheRightEdges) {
  const Camera camera = camera_from_fov({}, -0.9, 0.6, 0.5, -0.8, 640, 480);
  EXPECT_NEAR(pixel_of(camera, {std::tan(-0.9), 0, -1}).x(), 0, kRounding);
  EXPECT_NEAR(pixel_of(camera, {std::tan(0.6), 0, -1}).x(), 640, kRounding);
  EXPECT_NEAR(pixel_of(camera, {0, std::tan(0.5), -1}).y(), 0, kRounding);
  EXPECT_NEAR(pixel_of(camera, {0, std::tan(-0.8), -1}).y(), 480, kRounding);
}

TEST(Camera, JacobianLimitsFollowTheFrustum) {
  const Projection projection(camera_from_fov({}, -0.9, 0.6, 0.5, -0.8, 640, 480));
  // 15 % of the image beyond each edge, as slopes.
  const double beyond_x = 0.15 * (std::tan(0.6) - std::tan(-0.9));
  const double beyond_y = 0.15 * (std::tan(0.5) - std::tan(-0.8));
  EXPECT_NEAR(projection.min_slope_x, std::tan(-0.9) - beyond_x, kRounding);
  EXPECT_NEAR(projection.max_slope_x, std::tan(0.6) + beyond_x, kRounding);
  EXPECT_NEAR(projection.min_slope_y, -std::tan(0.5) - beyond_y, kRounding);  // y of the image runs down
  EXPECT_NEAR(projection.max_slope_y, -std::tan(-0.8) + beyond_y, kRounding);
}

TEST(Camera, FrameBoundsShowsEveryCorner) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, 0, -0.2), Eigen::Vector3d(2, 0.5, 1));
  for (const double azimuth : {0.0, 1.0, 2.5, -2.0}) {
    const Camera camera = frame_bounds(box, 640, 480, azimuth, 0.4);
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector2d p =
          pixel_of(camera, box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
      EXPECT_TRUE(p.x() >= 0 && p.x() <= 640 && p.y() >= 0 && p.y() <= 480)
          << azimuth << " corner " << corner;
    }
  }
}

// A row of boxes on a floor fills nine tenths of the width; one tall box nine tenths of the height.
TEST(Camera, FrameBoxesFillsThePicture) {
  const std::vector<Eigen::AlignedBox3d> row = {{Eigen::Vector3d(-2, 0, -0.5), Eigen::Vector3d(-1, 1, 0)},
                                                {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.3, 0.2, 0.4)},
                                                {Eigen::Vector3d(1.2, 0, -0.2), Eigen::Vector3d(1.9, 0.7, 0)},
                                                {}};
  const std::vector<Eigen::AlignedBox3d> tall = {{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1, 2, 0.1)}};
  for (const auto& boxes : {row, tall}) {
    for (const double azimuth : {0.0, 0.6, -2.0}) {
      Eigen::AlignedBox2d seen;
      const Camera camera = frame_boxes(boxes, 640, 480, azimuth, 0.3);
      for (const Eigen::AlignedBox3d& box : boxes) {
        if (box.isEmpty()) continue;
        for (int corner = 0; corner < 8; ++corner)
          seen.extend(pixel_of(camera, box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
      }
      EXPECT_GE(seen.min().x(), 32 - 1e-6);
      EXPECT_GE(seen.min().y(), 24 - 1e-6);
      EXPECT_NEAR(std::max(seen.sizes().x() / 640, seen.sizes().y() / 480), 0.9, 1e-9) << azimuth;
    }
  }
  EXPECT_TRUE(frame_boxes({}, 640, 480).world_from_camera.position_m.allFinite());
}

TEST(Camera, RobustBoundsExcludeFloaters) {
  std::vector<Eigen::Vector3f> positions_m;
  for (int i = 0; i <= 1000; ++i) positions_m.emplace_back(0.001f * static_cast<float>(i), 0.5f, -2.0f);
  positions_m.emplace_back(90.0f, -80.0f, 70.0f);
  const Eigen::AlignedBox3d box = robust_bounds(positions_m);
  EXPECT_NEAR(box.min().x(), 0.01, 2e-3);
  EXPECT_NEAR(box.max().x(), 0.99, 2e-3);
  EXPECT_NEAR(box.sizes().tail<2>().norm(), 0.0, 1e-9);
  EXPECT_TRUE(robust_bounds({}).isEmpty());
}

}  // namespace
}  // namespace livegs

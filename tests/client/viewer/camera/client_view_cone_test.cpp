// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/client_view_cone.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace livegs {
namespace {

// Everything in the picture is in the cone, and points behind the head are not.
void expect_all_seen(std::span<const Camera> eyes, const ViewCone& cone) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0, 1);
  for (const Camera& eye : eyes) {
    for (int i = 0; i < 500; ++i) {
      const double x_px = share(random) * eye.width, y_px = share(random) * eye.height,
                   away_m = 0.1 + 20 * share(random);
      const Eigen::Vector3d at_eye((x_px - eye.centre_x_px) / eye.focal_x_px * away_m,
                                   (eye.centre_y_px - y_px) / eye.focal_y_px * away_m, -away_m);
      EXPECT_TRUE(cone.touches(eye.world_from_camera * at_eye, 0)) << at_eye.transpose();
    }
    EXPECT_FALSE(cone.touches(eye.world_from_camera * Eigen::Vector3d(0, 0, 3), 0.1));
  }
}

TEST(SeenCone, ContainsViewOfWindow) {
  const Camera window = look_at({1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, 0.9, 1280, 720);
  expect_all_seen(std::span(&window, 1), client_view_cone(std::span(&window, 1)));
}

// Asymmetric, 64 mm apart, and canted as in some headsets.
TEST(SeenCone, ContainsViewOfBothEyes) {
  std::array<Camera, 2> eyes;
  for (int eye = 0; eye < 2; ++eye) {
    const double side = eye == 0 ? -1 : 1;
    const Pose pose{{0.032 * side, 1.6, 0},
                    Eigen::Quaterniond(Eigen::AngleAxisd(-0.1 * side, Eigen::Vector3d::UnitY()))};
    eyes[static_cast<size_t>(eye)] = eye == 0 ? camera_from_fov(pose, -0.9, 0.7, 0.7, -0.8, 800, 900)
                                              : camera_from_fov(pose, -0.7, 0.9, 0.7, -0.8, 800, 900);
  }
  const ViewCone cone = client_view_cone(eyes);
  expect_all_seen(eyes, cone);
  // A turn by 0.3 rad before the server receives the new view stays within the cone.
  std::array<Camera, 2> turned = eyes;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  for (Camera& eye : turned)
    eye.world_from_camera = {turn * eye.world_from_camera.position_m,
                             turn * eye.world_from_camera.orientation};
  expect_all_seen(turned, cone);
}

}  // namespace
}  // namespace livegs

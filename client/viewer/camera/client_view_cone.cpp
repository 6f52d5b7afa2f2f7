// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/client_view_cone.h"

#include <algorithm>

#include "core/assert.h"

namespace livegs {
namespace {

// Margin for head rotation at 2 to 4 rad/s.
constexpr double kTurnMargin_rad = 0.35;
// Margin for lateral motion in the same time.
constexpr double kMotionMargin_m = 0.2;

Eigen::Vector3d direction(const Camera& eye, double x_px, double y_px) {
  const Eigen::Vector3d ahead((x_px - eye.centre_x_px) / eye.focal_x_px,
                              (eye.centre_y_px - y_px) / eye.focal_y_px, -1.0);
  return eye.world_from_camera.orientation * ahead.normalized();
}

}  // namespace

ViewCone client_view_cone(std::span<const Camera> eyes) {
  LIVEGS_ASSERT(!eyes.empty());
  ViewCone cone;
  cone.forward.setZero();
  for (const Camera& eye : eyes) {
    cone.position_m += eye.world_from_camera.position_m / static_cast<double>(eyes.size());
    cone.forward += direction(eye, 0.5 * eye.width, 0.5 * eye.height);
  }
  cone.forward.normalize();
  cone.half_angle_rad = 0;
  double apart_m = kMotionMargin_m;
  for (const Camera& eye : eyes) {
    apart_m =
        std::max(apart_m, kMotionMargin_m + (eye.world_from_camera.position_m - cone.position_m).norm());
    for (const double x_px : {0.0, static_cast<double>(eye.width)}) {
      for (const double y_px : {0.0, static_cast<double>(eye.height)}) {
        const double cosine = std::clamp(direction(eye, x_px, y_px).dot(cone.forward), -1.0, 1.0);
        cone.half_angle_rad = std::max(cone.half_angle_rad, std::acos(cosine));
      }
    }
  }
  cone.half_angle_rad = std::min(M_PI, cone.half_angle_rad + kTurnMargin_rad);
  // Moving back by this distance makes the cone contain those of all points within apart_m.
  cone.position_m -= cone.forward * (apart_m / std::sin(std::min(cone.half_angle_rad, 0.5 * M_PI)));
  return cone;
}

}  // namespace livegs

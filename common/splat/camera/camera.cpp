// SPDX-License-Identifier: Apache-2.0
#include "splat/camera.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/assert.h"

namespace livegs {
namespace {

// The columns are the camera axes in the world. If the view is along `up`, the horizon is arbitrary.
Eigen::Quaterniond orientation_towards(const Eigen::Vector3d& forward, const Eigen::Vector3d& up) {
  const Eigen::Vector3d back = -forward.normalized();
  Eigen::Vector3d right = up.normalized().cross(back);
  if (!(right.norm() > 1e-9)) right = back.unitOrthogonal();
  right.normalize();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << right, back.cross(right), back;
  return Eigen::Quaterniond(world_from_camera).normalized();
}

}  // namespace

Camera look_at(const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m, const Eigen::Vector3d& up,
               double vertical_fov_rad, int width, int height) {
  LIVEGS_ASSERT(vertical_fov_rad > 0.0 && vertical_fov_rad < M_PI);
  LIVEGS_ASSERT(width > 0 && height > 0);
  const Eigen::Vector3d forward = target_m - position_m;
  const double focal_px = 0.5 * height / std::tan(0.5 * vertical_fov_rad);
  Camera camera;
  camera.world_from_camera.position_m = position_m;
  if (forward.norm() > 0.0) camera.world_from_camera.orientation = orientation_towards(forward, up);
  camera.width = width;
  camera.height = height;
  camera.focal_x_px = focal_px;
  camera.focal_y_px = focal_px;
  camera.centre_x_px = 0.5 * width;
  camera.centre_y_px = 0.5 * height;
  return camera;
}

Camera camera_from_fov(const Pose& world_from_camera, double left_rad, double right_rad, double up_rad,
                       double down_rad, int width, int height) {
  LIVEGS_ASSERT(left_rad < right_rad && down_rad < up_rad);
  LIVEGS_ASSERT(width > 0 && height > 0);
  const double left = std::tan(left_rad), right = std::tan(right_rad);
  const double up = std::tan(up_rad), down = std::tan(down_rad);
  Camera camera;
  camera.world_from_camera = world_from_camera;
  camera.width = width;
  camera.height = height;
  camera.focal_x_px = width / (right - left);
  camera.focal_y_px = height / (up - down);
  camera.centre_x_px = -left * camera.focal_x_px;
  camera.centre_y_px = up * camera.focal_y_px;  // rows run downwards
  return camera;
}

}  // namespace livegs

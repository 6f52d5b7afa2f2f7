// SPDX-License-Identifier: Apache-2.0
#include "viewer/camera/orbit_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/math/rotation_between.h"

namespace livegs {
namespace {

constexpr double kMaxElevation_rad = 1.55;
constexpr double kMinDistance_m = 0.05;
constexpr double kFrameMargin = 1.1;  // of a framed box: its sphere over the height of the picture

}  // namespace

OrbitCamera::OrbitCamera(const Camera& camera, double distance_m)
    : distance_m_(std::max(kMinDistance_m, distance_m)),
      vertical_fov_rad_(2.0 * std::atan(0.5 * camera.height / camera.focal_y_px)) {
  const Eigen::Vector3d back = camera.world_from_camera.orientation * Eigen::Vector3d::UnitZ();
  target_m_ = camera.world_from_camera.position_m - distance_m_ * back;
  azimuth_rad_ = std::atan2(back.x(), back.z());
  elevation_rad_ =
      std::clamp(std::asin(std::clamp(back.y(), -1.0, 1.0)), -kMaxElevation_rad, kMaxElevation_rad);
}

Eigen::Quaterniond OrbitCamera::orientation() const {
  return Eigen::AngleAxisd(azimuth_rad_, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(-elevation_rad_, Eigen::Vector3d::UnitX());
}

void OrbitCamera::orbit(const Eigen::Vector2d& moved_px, double window_height_px) {
  azimuth_rad_ = std::remainder(azimuth_rad_ - M_PI * moved_px.x() / window_height_px, 2.0 * M_PI);
  elevation_rad_ = std::clamp(elevation_rad_ + M_PI * moved_px.y() / window_height_px, -kMaxElevation_rad,
                              kMaxElevation_rad);
}

void OrbitCamera::pan(const Eigen::Vector2d& moved_px, double window_height_px) {
  const double metres_a_px = 2.0 * distance_m_ * std::tan(0.5 * vertical_fov_rad_) / window_height_px;
  target_m_ += orientation() * (metres_a_px * Eigen::Vector3d(-moved_px.x(), moved_px.y(), 0));
}

void OrbitCamera::zoom(double notches) {
  distance_m_ = std::max(kMinDistance_m, distance_m_ * std::pow(0.9, notches));
}

void OrbitCamera::fly(const Eigen::Vector3d& direction, double passed_s) {
  target_m_ += orientation() * (std::min(passed_s, 0.1) * distance_m_ * direction);
}

void OrbitCamera::frame(const Eigen::AlignedBox3d& box_m) {
  target_m_ = box_m.center();
  const double radius_m = 0.5 * box_m.sizes().norm();
  distance_m_ = std::max(kMinDistance_m, kFrameMargin * radius_m / std::sin(0.5 * vertical_fov_rad_));
}

void OrbitCamera::look(const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m) {
  const Eigen::Vector3d back = position_m - target_m;
  if (!(back.norm() > kMinDistance_m)) return;
  target_m_ = target_m;
  distance_m_ = back.norm();
  azimuth_rad_ = std::atan2(back.x(), back.z());
  elevation_rad_ = std::clamp(std::asin(back.y() / distance_m_), -kMaxElevation_rad, kMaxElevation_rad);
}

Camera OrbitCamera::camera(int width, int height) const {
  const Eigen::Quaterniond turned = orientation();
  Camera camera = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY(), vertical_fov_rad_, width, height);
  camera.world_from_camera = {target_m_ + turned * Eigen::Vector3d(0, 0, distance_m_), turned};
  return camera;
}

Pose ray_through(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d direction((pixel.x() - camera.centre_x_px) / camera.focal_x_px,
                                  -(pixel.y() - camera.centre_y_px) / camera.focal_y_px, -1.0);
  const Pose& eye = camera.world_from_camera;
  const Eigen::Quaterniond turn = rotation_between(-Eigen::Vector3d::UnitZ(), direction);
  return {eye.position_m, (eye.orientation * turn).normalized()};
}

std::optional<Eigen::Vector2d> pixel_of(const Camera& camera, const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d seen = camera.world_from_camera.inverse() * point_m;
  if (!(seen.z() < -1e-6)) return std::nullopt;
  return Eigen::Vector2d(camera.centre_x_px - camera.focal_x_px * seen.x() / seen.z(),
                         camera.centre_y_px + camera.focal_y_px * seen.y() / seen.z());
}

}  // namespace livegs

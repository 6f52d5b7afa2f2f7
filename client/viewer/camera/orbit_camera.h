// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "splat/camera.h"

namespace livegs {

// A camera that looks at a point from a distance, as a mouse and a few keys move it.
class OrbitCamera {
 public:
  OrbitCamera() = default;
  // Where `camera` stands; the point it looks at lies `distance_m` before it.
  OrbitCamera(const Camera& camera, double distance_m);

  // Around the point: a drag over the height of the window is half a turn. The poles are not crossed.
  void orbit(const Eigen::Vector2d& moved_px, double window_height_px);
  // With the point, so that what lies there follows the mouse.
  void pan(const Eigen::Vector2d& moved_px, double window_height_px);
  // Nearer to the point: each notch leaves nine tenths of the way.
  void zoom(double notches);
  // With the point, by `direction` in the camera's axes, as far a second as the point is away.
  void fly(const Eigen::Vector3d& direction, double passed_s);

  Camera camera(int width, int height) const;
  const Eigen::Vector3d& target_m() const { return target_m_; }

 private:
  Eigen::Quaterniond orientation() const;

  Eigen::Vector3d target_m_{0, 0, 0};
  double distance_m_ = 1, azimuth_rad_ = 0, elevation_rad_ = 0;
  double vertical_fov_rad_ = 0.7;
};

// The ray of a pixel, from the eye: origin and -Z.
Pose ray_through(const Camera& camera, const Eigen::Vector2d& pixel);
// Where a point is seen; nothing if it lies behind the eye.
std::optional<Eigen::Vector2d> pixel_of(const Camera& camera, const Eigen::Vector3d& point_m);

}  // namespace livegs

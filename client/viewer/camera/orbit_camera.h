// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "splat/camera.h"

namespace livegs {

// A camera that looks at a target point from a distance, controlled by mouse and keys.
class OrbitCamera {
 public:
  OrbitCamera() = default;
  // Takes the pose of `camera`; the target is `distance_m` in front of it.
  OrbitCamera(const Camera& camera, double distance_m);

  // Rotates around the target; a drag over the window's height is half a turn. Stops at the poles.
  void orbit(const Eigen::Vector2d& moved_px, double window_height_px);
  // Moves camera and target so that the target plane follows the mouse.
  void pan(const Eigen::Vector2d& moved_px, double window_height_px);
  // Moves towards the target; each notch leaves nine tenths of the distance.
  void zoom(double notches);
  // Moves camera and target along `direction` (camera axes); speed per second: the distance to the target.
  void fly(const Eigen::Vector3d& direction, double passed_s);

  // Looks at a box so that it fills most of the picture, from the same direction.
  void frame(const Eigen::AlignedBox3d& box_m);
  void look(const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m);

  Camera camera(int width, int height) const;
  const Eigen::Vector3d& target_m() const { return target_m_; }

 private:
  Eigen::Quaterniond orientation() const;

  Eigen::Vector3d target_m_{0, 0, 0};
  double distance_m_ = 1, azimuth_rad_ = 0, elevation_rad_ = 0;
  double vertical_fov_rad_ = 0.7;
};

// The ray through a pixel, from the eye: origin and -Z.
Pose ray_through(const Camera& camera, const Eigen::Vector2d& pixel);
// Projects a point; nothing if it is behind the eye.
std::optional<Eigen::Vector2d> pixel_of(const Camera& camera, const Eigen::Vector3d& point_m);

}  // namespace livegs

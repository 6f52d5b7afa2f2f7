// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "core/pose.h"

namespace livegs {

// A pinhole camera in the frame of OpenXR: x right, y up, looking along -z. Pixel (0, 0) is at the top left;
// its centre is (0.5, 0.5).
struct Camera {
  Pose world_from_camera;
  int width = 640;
  int height = 480;
  double focal_x_px = 500.0;
  double focal_y_px = 500.0;
  double centre_x_px = 320.0;  // asymmetric for a headset's eye
  double centre_y_px = 240.0;
  double near_m = 0.05;  // near limit of drawing; opacity fades in up to three times this distance
};

// vertical_fov_rad in (0, pi).
Camera look_at(const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m, const Eigen::Vector3d& up,
               double vertical_fov_rad, int width, int height);

// The asymmetric frustum of a headset's eye. Angles from the view axis in radians, left and down negative
// (XrFovf).
Camera camera_from_fov(const Pose& world_from_camera, double left_rad, double right_rad, double up_rad,
                       double down_rad, int width, int height);

}  // namespace livegs

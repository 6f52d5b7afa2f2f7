// SPDX-License-Identifier: Apache-2.0
#include "render/choose_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "splat/frame_bounds.h"

namespace livegs {
namespace {

// An environment whose middle is nearer than this to the objects' middle, in units of their size, is around
// them.
constexpr double kAround = 0.15;
// Room at the picture's edge for what moves: 10 % of the half width.
constexpr double kFilled = 0.9;

// The nearest camera with this orientation that sees all points. In its axes, with the camera at (cx, cz), a
// point is inside the half angle t if |x - cx| <= t (cz - z); both edges together need 2 t cz >= max(x + t z)
// - min(x - t z), and cx stands in the middle of what is left.
Eigen::Vector3d nearest_position(const std::vector<Eigen::Vector3d>& points,
                                 const Eigen::Quaterniond& orientation,
                                 const std::array<double, 2>& tangents) {
  std::array<double, 2> rightmost, leftmost;
  rightmost.fill(-std::numeric_limits<double>::infinity());
  leftmost.fill(std::numeric_limits<double>::infinity());
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d seen = orientation.conjugate() * point;
    for (int axis = 0; axis < 2; ++axis) {
      rightmost[axis] = std::max(rightmost[axis], seen[axis] + tangents[axis] * seen.z());
      leftmost[axis] = std::min(leftmost[axis], seen[axis] - tangents[axis] * seen.z());
    }
  }
  double back = -std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    back = std::max(back, (rightmost[axis] - leftmost[axis]) / (2 * tangents[axis]));
  }
  return orientation *
         Eigen::Vector3d(0.5 * (rightmost[0] + leftmost[0]), 0.5 * (rightmost[1] + leftmost[1]), back);
}

}  // namespace

Camera choose_camera(const SceneView& view, int width, int height) {
  Eigen::AlignedBox3d all;
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::AlignedBox3d& box : view.object_boxes()) {
    all.extend(box);
    for (int i = 0; i < 8; ++i)
      corners.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  }
  if (corners.empty()) {
    return frame_bounds({Eigen::Vector3d::Constant(-0.5), Eigen::Vector3d::Constant(0.5)}, width, height);
  }
  double azimuth_rad = 0.0;
  if (const auto environment = view.environment_middle()) {
    const Eigen::Vector3d away = all.center() - *environment;
    if (std::hypot(away.x(), away.z()) > kAround * all.sizes().maxCoeff()) {
      azimuth_rad = std::atan2(away.x(), away.z());
    }
  }
  Camera camera = frame_bounds(all, width, height, azimuth_rad);
  const double tangent_x = kFilled * 0.5 * width / camera.focal_x_px;
  const double tangent_y = kFilled * 0.5 * height / camera.focal_y_px;
  Pose& pose = camera.world_from_camera;
  pose.position_m = nearest_position(corners, pose.orientation, {tangent_x, tangent_y});
  return camera;
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "render/choose_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "splat/frame_bounds.h"

namespace livegs {
namespace {

// An environment whose centre is nearer than this to the objects' centre, relative to their size, surrounds
// them.
constexpr double kMaxCentreOffset = 0.15;
// Share of the half width (picture or free columns) that is filled; the rest is a margin for motion.
constexpr double kFillShare = 0.9;

// Tangents of the angles from the view direction to the edges along an axis; `low` is positive towards -axis.
struct Tangents {
  double low = 0, high = 0;
};

// The nearest camera with this orientation that sees all points. In its axes, with the camera at (cx, cz), a
// point is inside the edges l and h if -l (cz - z) <= x - cx <= h (cz - z). Both edges together require
// (l + h) cz >= max(x + h z) - min(x - l z); cx is the centre of the remaining interval.
Eigen::Vector3d nearest_position(const std::vector<Eigen::Vector3d>& points,
                                 const Eigen::Quaterniond& orientation,
                                 const std::array<Tangents, 2>& tangents) {
  std::array<double, 2> rightmost, leftmost;
  rightmost.fill(-std::numeric_limits<double>::infinity());
  leftmost.fill(std::numeric_limits<double>::infinity());
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d seen = orientation.conjugate() * point;
    for (int axis = 0; axis < 2; ++axis) {
      rightmost[axis] = std::max(rightmost[axis], seen[axis] + tangents[axis].high * seen.z());
      leftmost[axis] = std::min(leftmost[axis], seen[axis] - tangents[axis].low * seen.z());
    }
  }
  double back = -std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    back = std::max(back, (rightmost[axis] - leftmost[axis]) / (tangents[axis].low + tangents[axis].high));
  }
  const auto middle = [&](int axis) {
    return 0.5 * (rightmost[axis] + leftmost[axis] + (tangents[axis].low - tangents[axis].high) * back);
  };
  return orientation * Eigen::Vector3d(middle(0), middle(1), back);
}

}  // namespace

Camera choose_camera(const SceneView& view, int width, int height,
                     const std::optional<PictureColumns>& free) {
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
    if (std::hypot(away.x(), away.z()) > kMaxCentreOffset * all.sizes().maxCoeff()) {
      azimuth_rad = std::atan2(away.x(), away.z());
    }
  }
  Camera camera = frame_bounds(all, width, height, azimuth_rad);
  const PictureColumns columns = free.value_or(PictureColumns{0, static_cast<double>(width)});
  const double offset_px = 0.5 * (columns.left_px + columns.right_px - width);
  const double half_width_px = kFillShare * 0.5 * (columns.right_px - columns.left_px);
  const double tangent_y = kFillShare * 0.5 * height / camera.focal_y_px;
  Pose& pose = camera.world_from_camera;
  pose.position_m = nearest_position(corners, pose.orientation,
                                     {Tangents{(half_width_px - offset_px) / camera.focal_x_px,
                                               (half_width_px + offset_px) / camera.focal_x_px},
                                      Tangents{tangent_y, tangent_y}});
  return camera;
}

}  // namespace livegs

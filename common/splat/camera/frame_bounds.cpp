// SPDX-License-Identifier: Apache-2.0
#include "splat/frame_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace livegs {
namespace {

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

Camera frame_bounds(const Eigen::AlignedBox3d& bounds_m, int width, int height, double azimuth_rad,
                    double elevation_rad) {
  const Eigen::Vector3d centre =
      bounds_m.isEmpty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(bounds_m.center());
  const Eigen::Vector3d direction(std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad),
                                  std::cos(azimuth_rad) * std::cos(elevation_rad));
  const double tangent_y = std::tan(0.5 * kDefaultVerticalFov_rad);
  const double tangent_x = tangent_y * width / height;
  // The smallest distance at which all corners of the box are within both half angles.
  Camera camera =
      look_at(centre + direction, centre, Eigen::Vector3d::UnitY(), kDefaultVerticalFov_rad, width, height);
  const Eigen::Matrix3d camera_from_world =
      camera.world_from_camera.orientation.conjugate().toRotationMatrix();
  double distance = 0.1;
  if (!bounds_m.isEmpty()) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d offset =
          camera_from_world *
          (bounds_m.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - centre);
      distance = std::max({distance, offset.z() + std::abs(offset.x()) / tangent_x,
                           offset.z() + std::abs(offset.y()) / tangent_y});
    }
  }
  return look_at(centre + 1.06 * distance * direction, centre, Eigen::Vector3d::UnitY(),
                 kDefaultVerticalFov_rad, width, height);
}

Camera frame_boxes(std::span<const Eigen::AlignedBox3d> boxes_m, int width, int height, double azimuth_rad,
                   double elevation_rad, const std::optional<PictureColumns>& free) {
  Eigen::AlignedBox3d all;
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::AlignedBox3d& box : boxes_m) {
    if (box.isEmpty()) continue;
    all.extend(box);
    for (int i = 0; i < 8; ++i)
      corners.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  }
  if (corners.empty()) {
    const Eigen::AlignedBox3d metre(Eigen::Vector3d::Constant(-0.5), Eigen::Vector3d::Constant(0.5));
    return frame_boxes(std::span(&metre, 1), width, height, azimuth_rad, elevation_rad, free);
  }
  Camera camera = frame_bounds(all, width, height, azimuth_rad, elevation_rad);
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

Eigen::AlignedBox3d robust_bounds(const std::vector<Eigen::Vector3f>& positions_m) {
  Eigen::AlignedBox3d box;
  if (positions_m.empty()) return box;
  std::vector<float> along(positions_m.size());
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < positions_m.size(); ++i) along[i] = positions_m[i][axis];
    const auto at = [&](double share) {
      const auto rank =
          along.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(along.size() - 1));
      std::nth_element(along.begin(), rank, along.end());
      return static_cast<double>(*rank);
    };
    low[axis] = at(0.01);
    high[axis] = at(0.99);
  }
  return {low, high};
}

}  // namespace livegs

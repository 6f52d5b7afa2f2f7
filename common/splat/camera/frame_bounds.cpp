// SPDX-License-Identifier: Apache-2.0
#include "splat/frame_bounds.h"

#include <algorithm>
#include <cmath>

namespace livegs {

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

}  // namespace livegs

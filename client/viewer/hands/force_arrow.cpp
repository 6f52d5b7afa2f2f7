// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/force_arrow.h"

#include <Eigen/Geometry>

#include "viewer/camera/orbit_camera.h"

namespace livegs {
namespace {

constexpr double kWeightLength = 0.4;                                        // relative to the object's size
constexpr double kUnknownLength_m_n = 0.01;                                  // for objects without a mass
constexpr double kShaftWidth = 0.10, kHeadWidth = 0.28, kHeadLength = 0.32;  // relative to the length
constexpr double kMinArrowLength_px = 4;

}  // namespace

double arrow_metres_per_newton(double mass_kg, double size_m) {
  if (!(mass_kg > 0) || !(size_m > 0)) return kUnknownLength_m_n;
  return kWeightLength * size_m / (9.81 * mass_kg);
}

std::optional<ProjectedArrow> project_arrow(const Camera& camera, const Eigen::Vector3d& point_m,
                                            const Eigen::Vector3d& force_n, double metres_per_newton) {
  const Eigen::Vector3d along = metres_per_newton * force_n;
  const double length_m = along.norm();
  if (!(length_m > 0)) return std::nullopt;
  const Eigen::Vector3d view = point_m - camera.world_from_camera.position_m;
  Eigen::Vector3d side = along.cross(view);
  if (side.norm() < 1e-9 * length_m * view.norm()) return std::nullopt;  // along the line of sight
  side.normalize();
  const auto corner = [&](double forward, double width) -> Eigen::Vector3d {
    return point_m + forward * along + 0.5 * width * length_m * side;
  };
  const std::array<Eigen::Vector3d, 7> corners = {corner(0, -kShaftWidth),
                                                  corner(1 - kHeadLength, -kShaftWidth),
                                                  corner(1 - kHeadLength, -kHeadWidth),
                                                  corner(1, 0),
                                                  corner(1 - kHeadLength, kHeadWidth),
                                                  corner(1 - kHeadLength, kShaftWidth),
                                                  corner(0, kShaftWidth)};
  ProjectedArrow seen;
  for (size_t i = 0; i < corners.size(); ++i) {
    const auto pixel = pixel_of(camera, corners[i]);
    if (!pixel) return std::nullopt;
    seen.outline_px[i] = *pixel;
  }
  if ((seen.outline_px[3] - 0.5 * (seen.outline_px[0] + seen.outline_px[6])).norm() < kMinArrowLength_px) {
    return std::nullopt;
  }
  return seen;
}

}  // namespace livegs

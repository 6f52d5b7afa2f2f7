// SPDX-License-Identifier: Apache-2.0
#include "viewer/hands/force_arrow.h"

#include <algorithm>
#include <limits>

namespace livegs {
namespace {

constexpr double kWeightLength = 0.4;        // relative to the object's size
constexpr double kUnknownLength_m_n = 0.01;  // for objects without a mass
constexpr double kMinArrowLength_px = 4;     // shorter arrows are not drawn
constexpr double kMaxArrowShare = 0.3;       // of the picture's shorter side; larger: hides the pulled object
constexpr double kEdgeMargin_px = 24;        // between the tip and the edge, for the barbs and the outline
constexpr double kMaxHeadShare = 0.6;        // of the length, for arrows shorter than about 30 px

// Distance from a point to the edge of the range [low, high] in the direction of `step`.
double room(double at, double step, double low, double high) {
  if (step == 0) return std::numeric_limits<double>::infinity();
  return std::max(0.0, ((step > 0 ? high : low) - at) / step);
}

}  // namespace

double arrow_metres_per_newton(double mass_kg, double size_m) {
  if (!(mass_kg > 0) || !(size_m > 0)) return kUnknownLength_m_n;
  return kWeightLength * size_m / (9.81 * mass_kg);
}

std::optional<ProjectedArrow> project_arrow(const Camera& camera, const Eigen::Vector3d& point_m,
                                            const Eigen::Vector3d& force_n, double metres_per_newton) {
  const Pose& pose = camera.world_from_camera;
  const Eigen::Vector3d at_m = pose.orientation.conjugate() * (point_m - pose.position_m);
  const double depth_m = -at_m.z();
  if (!(depth_m > camera.near_m)) return std::nullopt;
  // The derivative of the projection: a tip behind the eye still has a direction.
  const Eigen::Vector3d along_m = pose.orientation.conjugate() * (metres_per_newton * force_n);
  const Eigen::Vector2d slope(at_m.x() / depth_m, -at_m.y() / depth_m);
  const Eigen::Vector2d focal_px(camera.focal_x_px, camera.focal_y_px);
  const Eigen::Vector2d tail_px =
      focal_px.cwiseProduct(slope) + Eigen::Vector2d(camera.centre_x_px, camera.centre_y_px);
  const Eigen::Vector2d along_px =
      focal_px.cwiseProduct(Eigen::Vector2d(along_m.x(), -along_m.y()) + along_m.z() * slope) / depth_m;
  if (!(along_px.norm() >= kMinArrowLength_px)) return std::nullopt;

  const Eigen::Vector2d forward = along_px.normalized();
  const double length_px =
      std::min({along_px.norm(), kMaxArrowShare * std::min(camera.width, camera.height),
                room(tail_px.x(), forward.x(), kEdgeMargin_px, camera.width - kEdgeMargin_px),
                room(tail_px.y(), forward.y(), kEdgeMargin_px, camera.height - kEdgeMargin_px)});
  if (!(length_px >= kMinArrowLength_px)) return std::nullopt;
  const Eigen::Vector2d left(forward.y(), -forward.x());
  const double neck_px = length_px - std::min(kArrowHeadLength_px, kMaxHeadShare * length_px);
  const auto corner = [&](double ahead_px, double width_px) -> Eigen::Vector2d {
    return tail_px + ahead_px * forward + 0.5 * width_px * left;
  };
  return ProjectedArrow{{corner(0, kArrowShaftWidth_px), corner(neck_px, kArrowShaftWidth_px),
                         corner(neck_px, kArrowHeadWidth_px), corner(length_px, 0),
                         corner(neck_px, -kArrowHeadWidth_px), corner(neck_px, -kArrowShaftWidth_px),
                         corner(0, -kArrowShaftWidth_px)}};
}

}  // namespace livegs

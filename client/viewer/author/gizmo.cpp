// SPDX-License-Identifier: Apache-2.0
#include "viewer/author/gizmo.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "viewer/camera/orbit_camera.h"

namespace livegs {
namespace {

constexpr double kArm_px = 90.0, kPick_px = 9.0, kPlane_px = 14.0;
constexpr int kRingParts = 48;
constexpr double kSnap_m = 0.1, kSnap_rad = M_PI / 12.0, kSnapScale = 0.1;
// A drag of Scale by this many pixels doubles the size.
constexpr double kDouble_px = 100.0;
constexpr double kMinSine = 0.05;  // between a ray and a plane, below which they count as parallel

// Length in the world of one pixel at a point.
double metres_a_px(const Camera& camera, const Eigen::Vector3d& at_m) {
  const Eigen::Vector3d seen = camera.world_from_camera.inverse() * at_m;
  return std::max(1e-4, -seen.z()) / camera.focal_y_px;
}

double rounded(double value, double step) { return step * std::round(value / step); }

// Parameter along an axis through `at_m` of the point nearest to the mouse's ray; nothing if they are
// parallel.
std::optional<double> along_axis(const Camera& camera, const Eigen::Vector2d& mouse_px,
                                 const Eigen::Vector3d& at_m, const Eigen::Vector3d& axis) {
  const Pose ray = ray_through(camera, mouse_px);
  const Eigen::Vector3d direction = ray.orientation * -Eigen::Vector3d::UnitZ();
  const double cosine = direction.dot(axis), sine_squared = 1.0 - cosine * cosine;
  if (sine_squared < kMinSine * kMinSine) return std::nullopt;
  const Eigen::Vector3d between = at_m - ray.position_m;
  return (cosine * between.dot(direction) - between.dot(axis)) / sine_squared;
}

// Where the mouse's ray meets a plane through `at_m`.
std::optional<Eigen::Vector3d> on_plane(const Camera& camera, const Eigen::Vector2d& mouse_px,
                                        const Eigen::Vector3d& at_m, const Eigen::Vector3d& normal) {
  const Pose ray = ray_through(camera, mouse_px);
  const Eigen::Vector3d direction = ray.orientation * -Eigen::Vector3d::UnitZ();
  const double sine = direction.dot(normal);
  if (std::abs(sine) < kMinSine) return std::nullopt;
  const double way = (at_m - ray.position_m).dot(normal) / sine;
  if (!(way > 0.0)) return std::nullopt;
  return ray.position_m + way * direction;
}

double distance_px(const Eigen::Vector2d& point, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double share = std::clamp((point - a).dot(along) / std::max(along.squaredNorm(), 1e-9), 0.0, 1.0);
  return (point - a - share * along).norm();
}

}  // namespace

std::vector<GizmoHandle> Gizmo::handles(GizmoTool tool, const Camera& camera, const Eigen::Vector3d& at_m) {
  std::vector<GizmoHandle> handles;
  const auto centre = pixel_of(camera, at_m);
  if (tool == GizmoTool::None || !centre) return handles;
  const double arm_m = kArm_px * metres_a_px(camera, at_m);
  if (tool == GizmoTool::Scale) {
    const Eigen::Vector2d corner = *centre + Eigen::Vector2d(0.7, -0.7) * kArm_px;
    handles.push_back({3, {*centre, corner}, true});
    return handles;
  }
  for (int axis = 0; axis < 3; ++axis) {
    GizmoHandle handle;
    handle.axis = axis;
    const Eigen::Vector3d direction = Eigen::Vector3d::Unit(axis);
    if (tool == GizmoTool::Move) {
      const auto tip = pixel_of(camera, at_m + arm_m * direction);
      if (!tip) continue;
      handle.line_px = {*centre, *tip};
      handle.arrow = true;
    } else {
      const Eigen::Vector3d u = Eigen::Vector3d::Unit((axis + 1) % 3), v = direction.cross(u);
      for (int i = 0; i <= kRingParts; ++i) {
        const double angle = 2.0 * M_PI * i / kRingParts;
        const auto point = pixel_of(camera, at_m + arm_m * (std::cos(angle) * u + std::sin(angle) * v));
        if (point) handle.line_px.push_back(*point);
      }
    }
    handles.push_back(std::move(handle));
  }
  if (tool == GizmoTool::Move) {
    GizmoHandle plane{3, {}, false};
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}, {-1, -1}})
      plane.line_px.push_back(*centre + 0.5 * kPlane_px * Eigen::Vector2d(x, y));
    handles.push_back(std::move(plane));
  }
  return handles;
}

std::optional<int> Gizmo::handle_at(GizmoTool tool, const Camera& camera, const Eigen::Vector3d& at_m,
                                    const Eigen::Vector2d& mouse_px) {
  std::optional<int> nearest;
  double least = kPick_px;
  const std::vector<GizmoHandle> all = handles(tool, camera, at_m);
  // The square in the middle lies on the axes and comes first.
  if (const auto centre = pixel_of(camera, at_m);
      centre && tool == GizmoTool::Move && (mouse_px - *centre).cwiseAbs().maxCoeff() <= 0.5 * kPlane_px)
    return 3;
  for (const GizmoHandle& handle : all) {
    for (size_t i = 0; i + 1 < handle.line_px.size(); ++i) {
      const double distance = distance_px(mouse_px, handle.line_px[i], handle.line_px[i + 1]);
      if (distance > least) continue;
      least = distance;
      nearest = handle.axis;
    }
  }
  return nearest;
}

void Gizmo::begin(GizmoTool tool, int axis, const Camera&, const Eigen::Vector3d& at_m,
                  const Eigen::Vector2d& mouse_px) {
  dragging_ = true;
  tool_ = tool;
  axis_ = axis;
  at_m_ = at_m;
  from_px_ = mouse_px;
}

GizmoChange Gizmo::drag(const Camera& camera, const Eigen::Vector2d& mouse_px, bool snaps) const {
  GizmoChange change;
  if (!dragging_) return change;
  if (tool_ == GizmoTool::Move && axis_ < 3) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(axis_);
    const auto from = along_axis(camera, from_px_, at_m_, axis),
               to = along_axis(camera, mouse_px, at_m_, axis);
    if (!from || !to) return change;
    const double way = *to - *from;
    change.shift_m = (snaps ? rounded(way, kSnap_m) : way) * axis;
  } else if (tool_ == GizmoTool::Move) {
    const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
    const auto from = on_plane(camera, from_px_, at_m_, up), to = on_plane(camera, mouse_px, at_m_, up);
    if (!from || !to) return change;
    change.shift_m = *to - *from;
    if (snaps) change.shift_m = change.shift_m.unaryExpr([](double way) { return rounded(way, kSnap_m); });
  } else if (tool_ == GizmoTool::Turn) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(axis_);
    const auto from = on_plane(camera, from_px_, at_m_, axis), to = on_plane(camera, mouse_px, at_m_, axis);
    double angle = 0.0;
    if (from && to) {
      const Eigen::Vector3d a = *from - at_m_, b = *to - at_m_;
      angle = std::atan2(a.cross(b).dot(axis), a.dot(b));
    } else {  // the ring is seen from its edge: half a turn over the ring's width
      angle = M_PI * (mouse_px.x() - from_px_.x()) / (2.0 * kArm_px);
    }
    change.rotation = Eigen::AngleAxisd(snaps ? rounded(angle, kSnap_rad) : angle, axis);
  } else if (tool_ == GizmoTool::Scale) {
    const Eigen::Vector2d way = mouse_px - from_px_;
    const double factor = std::exp2((way.x() - way.y()) / (2.0 * kDouble_px));
    change.scale = snaps ? std::max(kSnapScale, rounded(factor, kSnapScale)) : factor;
  }
  return change;
}

Pose changed_pose(const Pose& pose, const GizmoChange& change, const Eigen::Vector3d& pivot_m) {
  return {pivot_m + change.scale * (change.rotation * (pose.position_m - pivot_m)) + change.shift_m,
          (change.rotation * pose.orientation).normalized()};
}

}  // namespace livegs

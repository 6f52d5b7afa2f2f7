// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "splat/camera.h"

namespace livegs {

enum class GizmoTool { None, Move, Turn, Scale };

// One handle as drawn. Pixels from the top left.
struct GizmoHandle {
  int axis = 0;  // 0 x, 1 y, 2 z of the world; 3: the floor plane (move) or all axes (scale)
  std::vector<Eigen::Vector2d> line_px;
  bool arrow = false;  // the line ends in a tip
};

// Transform of a drag so far: about the pivot, rotation first, then scale, then the shift.
struct GizmoChange {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double scale = 1.0;
};

// Handles at a point of the world, of constant size on the screen, and the drag of one of them.
class Gizmo {
 public:
  static std::vector<GizmoHandle> handles(GizmoTool tool, const Camera& camera, const Eigen::Vector3d& at_m);
  // Handle within a few pixels of the mouse.
  static std::optional<int> handle_at(GizmoTool tool, const Camera& camera, const Eigen::Vector3d& at_m,
                                      const Eigen::Vector2d& mouse_px);

  void begin(GizmoTool tool, int axis, const Camera& camera, const Eigen::Vector3d& at_m,
             const Eigen::Vector2d& mouse_px);
  bool dragging() const { return dragging_; }
  int axis() const { return axis_; }
  // `snaps`: to 0.1 m, 15 degrees, 10 %.
  GizmoChange drag(const Camera& camera, const Eigen::Vector2d& mouse_px, bool snaps) const;
  void end() { dragging_ = false; }

 private:
  bool dragging_ = false;
  GizmoTool tool_ = GizmoTool::None;
  int axis_ = 0;
  Eigen::Vector3d at_m_ = Eigen::Vector3d::Zero();  // pivot when the drag began
  Eigen::Vector2d from_px_{0, 0};
};

// The pose of an object after a change about a pivot.
Pose changed_pose(const Pose& pose, const GizmoChange& change, const Eigen::Vector3d& pivot_m);

}  // namespace livegs

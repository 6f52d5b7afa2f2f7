// SPDX-License-Identifier: Apache-2.0
#include "viewer/author/gizmo.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "viewer/author/object_pose.h"
#include "viewer/camera/orbit_camera.h"

namespace livegs {
namespace {

const Camera kAuthorView = look_at({0.5, 1.5, 3}, {0, 0.2, 0}, Eigen::Vector3d::UnitY(), 0.7, 800, 600);
const Eigen::Vector3d kAt(0.2, 0.3, -0.1);

Eigen::Vector2d seen(const Eigen::Vector3d& point_m) { return pixel_of(kAuthorView, point_m).value(); }

TEST(Gizmos, AnAxisIsTakenAtItsLineOnly) {
  const auto handles = Gizmo::handles(GizmoTool::Move, kAuthorView, kAt);
  ASSERT_EQ(handles.size(), 4u);
  for (int axis = 0; axis < 3; ++axis) {
    const auto& line = handles[static_cast<size_t>(axis)].line_px;
    const Eigen::Vector2d point = line.front() + 0.8 * (line.back() - line.front());
    EXPECT_EQ(Gizmo::handle_at(GizmoTool::Move, kAuthorView, kAt, point), axis);
  }
  EXPECT_EQ(Gizmo::handle_at(GizmoTool::Move, kAuthorView, kAt, seen(kAt)), 3);
  EXPECT_FALSE(Gizmo::handle_at(GizmoTool::Move, kAuthorView, kAt, {5, 5}));
  EXPECT_TRUE(Gizmo::handles(GizmoTool::None, kAuthorView, kAt).empty());
}

TEST(Gizmos, AMoveFollowsTheMouseAlongItsAxis) {
  for (int axis = 0; axis < 3; ++axis) {
    Gizmo gizmo;
    gizmo.begin(GizmoTool::Move, axis, kAuthorView, kAt, seen(kAt));
    const Eigen::Vector3d way = 0.37 * Eigen::Vector3d::Unit(axis);
    const GizmoChange free = gizmo.drag(kAuthorView, seen(kAt + way), false);
    EXPECT_LT((free.shift_m - way).norm(), 1e-9) << axis;
    const GizmoChange snapped = gizmo.drag(kAuthorView, seen(kAt + way), true);
    EXPECT_LT((snapped.shift_m - 0.4 * Eigen::Vector3d::Unit(axis)).norm(), 1e-9) << axis;
  }
  Gizmo plane;
  plane.begin(GizmoTool::Move, 3, kAuthorView, kAt, seen(kAt));
  const Eigen::Vector3d way(0.3, 0, -0.5);
  EXPECT_LT((plane.drag(kAuthorView, seen(kAt + way), false).shift_m - way).norm(), 1e-9);
}

TEST(Gizmos, ATurnFollowsTheMouseAroundItsAxis) {
  Gizmo gizmo;
  const Eigen::Vector3d from = kAt + Eigen::Vector3d(0.2, 0, 0);
  gizmo.begin(GizmoTool::Turn, 1, kAuthorView, kAt, seen(from));
  const Eigen::AngleAxisd half(0.5, Eigen::Vector3d::UnitY());
  const Eigen::Vector3d to = kAt + half * (from - kAt);
  const GizmoChange change = gizmo.drag(kAuthorView, seen(to), false);
  EXPECT_LT(change.rotation.angularDistance(Eigen::Quaterniond(half)), 1e-9);
  const Eigen::Quaterniond snapped = gizmo.drag(kAuthorView, seen(to), true).rotation;
  EXPECT_NEAR(Eigen::AngleAxisd(snapped).angle(), M_PI / 6, 1e-9) << "28.6 degrees, to 15";
}

TEST(Gizmos, AChangeKeepsThePivot) {
  const Pose pose{{1, 2, 3}, Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))};
  const Eigen::Vector3d pivot(0.5, 1.5, 2.5);
  GizmoChange change;
  change.rotation = Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitY());
  const Pose turned = changed_pose(pose, change, pivot);
  const Eigen::Vector3d rest = pose.inverse() * pivot;
  EXPECT_LT((turned * rest - pivot).norm(), 1e-12);
  EXPECT_LT(turned.orientation.angularDistance(change.rotation * pose.orientation), 1e-9);
}

TEST(ObjectPoses, AnglesAreThereAndBack) {
  for (const Eigen::Vector3d& angles : {Eigen::Vector3d(30, 20, -70), Eigen::Vector3d(-170, -80, 5),
                                        Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(45, 90, 0)}) {
    const Eigen::Quaterniond turn = orientation_of(angles);
    EXPECT_LT(turn.angularDistance(orientation_of(yaw_pitch_roll_deg(turn))), 1e-6) << angles.transpose();
  }
  EXPECT_LT((yaw_pitch_roll_deg(orientation_of({30, 20, -70})) - Eigen::Vector3d(30, 20, -70)).norm(), 1e-9);
}

TEST(ObjectPoses, OfAMovedLattice) {
  RestBody rest;
  rest.kind = DriverKind::Lattice;
  rest.cell_width_m = 0.1;
  rest.object_from_lattice = {{0.05, 0, 0},
                              Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()))};
  const Pose pose{{1, 0.5, -2},
                  Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized()))};
  ObjectDrivers drivers;
  drivers.kind = DriverKind::Lattice;
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 2; ++y) {
      for (int z = 0; z < 2; ++z) {
        rest.node_coordinates.emplace_back(x, y, z);
        const Eigen::Vector3d at = rest.object_from_lattice * Eigen::Vector3d(0.1 * x, 0.1 * y, 0.1 * z);
        drivers.positions_m.push_back((pose * at).cast<float>());
      }
    }
  }
  const Pose found = scene_pose(rest, drivers, 0.25);
  EXPECT_LT((found * Eigen::Vector3d(0, 0.25, 0) - pose.position_m).norm(), 1e-5)
      << "the body's frame is lifted";
  EXPECT_LT(found.orientation.angularDistance(pose.orientation), 1e-4);
}

}  // namespace
}  // namespace livegs

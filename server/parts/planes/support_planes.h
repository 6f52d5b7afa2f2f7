// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "parts/views/room_view.h"

// Large planes of a room: supports, on which things stand, and walls.

namespace livegs {

// Cells of a plane in which its surface is visible, and the convex hull of each connected area of them.
// Things hide the plane below and behind them, also at its edge. Small areas next to a large one are noise.
class PlaneRegion {
 public:
  PlaneRegion() = default;
  // `corners_m`: hidden corners of its largest area.
  PlaneRegion(const Eigen::Vector3d& normal, double cell_m, std::span<const Eigen::Vector3f> points_m,
              std::span<const Eigen::Vector3f> corners_m = {});

  bool contains(const Eigen::Vector3d& point_m) const;  // of its foot on the plane
  bool seen(const Eigen::Vector3d& point_m) const;      // without the filled holes
  double area_m2() const;
  const Eigen::Vector3d& u() const { return u_; }
  const Eigen::Vector3d& v() const { return v_; }
  double cell_m() const { return cell_m_; }
  // The bounding rectangle of the region along u() and v(), metres; empty without cells.
  Eigen::AlignedBox2d bounds_m() const;

 private:
  int cell_of(const Eigen::Vector3d& point_m) const;  // -1: outside
  std::vector<std::vector<int>> areas() const;        // connected seen cells
  void drop_specks();
  void fill_hulls(std::span<const Eigen::Vector3f> corners_m);

  Eigen::Vector3d u_{1, 0, 0}, v_{0, 0, 1};
  Eigen::Vector2d low_{0, 0};
  double cell_m_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<uint8_t> cells_;  // 0 outside, 1 filled, 2 seen
};

struct RoomPlane {
  Eigen::Vector3d normal{0, 1, 0};  // unit, towards the side from which it is seen
  double offset_m = 0;              // normal · point on the plane
  double deviation_m = 0;           // robust standard deviation of its points
  double share = 0;                 // of all points
  PlaneRegion region;

  double height_m(const Eigen::Vector3d& point_m) const { return normal.dot(point_m) - offset_m; }
};

struct RoomPlanes {
  std::vector<RoomPlane> supports;  // level, highest first; the floor is not marked
  std::vector<RoomPlane> walls;     // upright, with nothing behind them
};

// Finds planes by RANSAC on points (Fischler and Bolles 1981) with a fixed seed, and refits each to its
// points. `up` is a unit vector within 20 degrees of the vertical. `footprint_m` is the usual size of a
// pixel on the surface, the unit of all tolerances. Deterministic.
RoomPlanes find_planes(std::span<const ViewPoint> points, const Eigen::Vector3d& up, double footprint_m);

}  // namespace livegs

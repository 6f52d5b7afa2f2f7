// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/room_solids.h"

namespace livegs {
namespace {

constexpr double kTableThickness_voxels = 4;  // of the slab under a support that is not the floor
constexpr double kFloorGap_voxels = 6;        // a support this far above the lowest surface is a table

RoomSolid plane_at(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  return {point, normal, Eigen::Matrix3d::Identity(), std::nullopt};
}

}  // namespace

std::vector<RoomSolid> room_solids(const RoomParts& parts, const Eigen::Vector3d& up) {
  std::vector<RoomSolid> solids;
  bool floor = false;
  for (const RoomPlane& plane : parts.planes.supports) {
    if (plane.offset_m - parts.lowest_m < kFloorGap_voxels * parts.voxel_m) {
      solids.push_back(plane_at(plane.offset_m * plane.normal, plane.normal));
      floor = true;
      continue;
    }
    const PlaneRegion& region = plane.region;
    const Eigen::Vector2d size = region.bounds_m().sizes(), middle = region.bounds_m().center();
    const double thick_m = kTableThickness_voxels * parts.voxel_m;
    RoomSolid slab;
    slab.point_m =
        middle.x() * region.u() + middle.y() * region.v() + (plane.offset_m - 0.5 * thick_m) * plane.normal;
    slab.normal = plane.normal;
    slab.axes.col(0) = region.u();
    slab.axes.col(1) = plane.normal;
    slab.axes.col(2) = region.u().cross(plane.normal);
    slab.size_m = Eigen::Vector3d(size.x(), thick_m, size.y());
    solids.push_back(slab);
  }
  if (!floor) solids.push_back(plane_at(parts.lowest_m * up, up));
  for (const RoomPlane& wall : parts.planes.walls)
    solids.push_back(plane_at(wall.offset_m * wall.normal, wall.normal));
  return solids;
}

}  // namespace livegs

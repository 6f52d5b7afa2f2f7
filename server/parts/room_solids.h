// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "parts/room_parts.h"

namespace livegs {

// A plane or a slab with which things collide, in the frame of the asset.
struct RoomSolid {
  Eigen::Vector3d point_m;                             // on the plane, or the centre of the slab
  Eigen::Vector3d normal;                              // out of the solid
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // of the slab, as columns
  std::optional<Eigen::Vector3d> size_m;               // of the slab along its axes; none: a plane
};

// The floor and the walls as planes, each table as a slab below its top. If no floor is visible, a plane
// below everything is added.
std::vector<RoomSolid> room_solids(const RoomParts& parts, const Eigen::Vector3d& up);

}  // namespace livegs

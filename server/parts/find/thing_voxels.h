// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "parts/find/voxel_set.h"
#include "parts/planes/support_planes.h"

// The occupied voxels above supports, grouped into things.

namespace livegs {

// Sizes that follow from the footprint of a pixel on the surfaces.
struct PartScale {
  double footprint_m = 0;  // median edge of a pixel
  double voxel_m = 0;  // edge of a voxel: a little more than the distance of points, so that surfaces connect
  double foot_m(const RoomPlane& plane) const;  // least height of a thing above its support
};
// `stride`: between the pixels that gave points.
PartScale part_scale(std::span<const ViewPoint> points, int stride);

struct Thing {
  std::vector<uint32_t> voxels;
  std::optional<size_t> support, wall;
};

struct ThingVoxels {
  VoxelSet voxels;
  std::vector<uint32_t> support;  // of each voxel: index of the highest support below it
  std::vector<Thing> things;
};

// The highest support whose region is below the point; kNoVoxel if there is none.
uint32_t support_below(const RoomPlanes& planes, const Eigen::Vector3d& point_m, double margin_m);

// 1. Points above a support and away from walls become voxels.
// 2. Floaters are dropped: voxels that more views see through than see.
// 3. Connected voxels that touch their support or a wall are things. Voxels that touch the underside of a
//    support are furniture. They stay with the room, and so do specks.
ThingVoxels thing_voxels(std::span<const ViewPoint> points, std::span<const RoomView> views,
                         const RoomPlanes& planes, const PartScale& scale);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace livegs {

// One point of each occupied voxel: the one nearest to the voxel's centre, in order of the points. Voxels lie
// on a grid with a node at the origin. Preconditions: finite points, |coordinate| / voxel < 2^20.
std::vector<Eigen::Vector3d> thin_by_voxels(std::span<const Eigen::Vector3d> points, double voxel);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace livegs {

// One point of each occupied voxel: the one nearest to the voxel's centre, in order of the points. Voxels lie
// on a grid with a node at the origin. A voxel that holds fewer points than `least_share` of the median
// occupied voxel's is left out: strays. Preconditions: finite points, |coordinate| / voxel < 2^20, 0 <=
// least_share < 1.
std::vector<Eigen::Vector3d> thin_by_voxels(std::span<const Eigen::Vector3d> points, double voxel,
                                            double least_share = 0.0);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace livegs {

// Keeps one point per occupied voxel, the one nearest to the voxel's centre, in the order of the points. The
// voxel grid has a node at the origin. A voxel with fewer points than `least_share` of the median is dropped
// as stray. Preconditions: finite points, |coordinate| / voxel < 2^20, 0 <= least_share < 1.
std::vector<Eigen::Vector3d> thin_by_voxels(std::span<const Eigen::Vector3d> points, double voxel,
                                            double least_share = 0.0);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// Returns for each seed the seeds whose Voronoi cells share a face with its cell inside `bounds_m`, nearest
// first (voro++). Symmetric. Precondition: finite and distinct seeds; they may lie outside the bounds. Not
// thread-safe.
std::vector<std::vector<uint32_t>> voronoi_neighbours(std::span<const Eigen::Vector3d> seeds_m,
                                                      const Eigen::AlignedBox3d& bounds_m);

}  // namespace livegs

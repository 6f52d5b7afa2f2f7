// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "gaussian/posed_kernels.h"

namespace livegs {

// A kernel as a piece of the surface that is seen: its middle and its covariance. One standard deviation from
// the middle is taken for the surface.
struct SurfaceKernel {
  Eigen::Vector3f middle_m;
  Symmetric3f covariance_m2;
  uint32_t object_id = 0;
};

// The kernels of more than half opacity whose middle is within the box; `most` of them at most, evenly left
// out of more. One pass over all kernels: about 1 ms for a million.
std::vector<SurfaceKernel> surface_within(std::span<const DrawnObject> objects,
                                          const Eigen::AlignedBox3f& box, size_t most);

// Metres from a place to the nearest of them, negative within a kernel; infinity where there are none.
float distance_to_surface(std::span<const SurfaceKernel> surface, const Eigen::Vector3f& place_m);

}  // namespace livegs

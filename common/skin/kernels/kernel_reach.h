// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "skin/skin_kernels.h"

namespace livegs {

// Maximum distance of kernels from their drivers under any motion, including three standard deviations.
// Computed once; spatial queries use it to skip an object without skinning it.
struct KernelReach {
  std::vector<float> bodies_m;  // Rigid: for each body, from its origin
  float drivers_m = 0;          // Lattice, Particles: from the bounding box of all drivers
};
KernelReach kernel_reach(const RestBody& rest, const KernelBindings& bindings);

// A box that contains all kernels. `drivers` fit the rest body, or are kernels.
Eigen::AlignedBox3f box_of_kernels(const KernelReach& reach, const ObjectDrivers& drivers);

}  // namespace livegs

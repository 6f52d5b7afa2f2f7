// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "skin/skin_kernels.h"

namespace livegs {

// How far kernels may be from their drivers, three standard deviations included, however they move: worked
// out once, so that whoever looks for kernels at a place can leave out an object without skinning it.
struct KernelReach {
  std::vector<float> bodies_m;  // Rigid: of each body, from its origin
  float drivers_m = 0;          // Lattice, Particles: from the box about all drivers
};
KernelReach kernel_reach(const RestBody& rest, const KernelBindings& bindings);

// A box that all kernels are in. `drivers` fit the rest body, or are kernels.
Eigen::AlignedBox3f box_of_kernels(const KernelReach& reach, const ObjectDrivers& drivers);

}  // namespace livegs

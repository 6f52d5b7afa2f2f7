// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "gaussian/posed_kernels.h"

namespace livegs {

// The kernel that a ray hits.
struct PickedKernel {
  size_t object = 0;  // index into the given objects
  size_t kernel = 0;
  double distance_m = 0;
};

// Returns the kernel at the median depth, at which the ray has lost half of its light. A kernel counts where
// its density along the ray is highest. Nothing if more than half of the light passes. `direction` is a unit
// vector; kernels nearer than `near_m` are ignored. Cost: one pass over the kernels, a few nanoseconds each.
std::optional<PickedKernel> pick_kernel(std::span<const DrawnObject> objects, const Eigen::Vector3d& origin_m,
                                        const Eigen::Vector3d& direction, double near_m = 0.05);

}  // namespace livegs

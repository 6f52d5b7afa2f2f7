// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "gaussian/posed_kernels.h"

namespace livegs {

// The kernel that a ray meets.
struct PickedKernel {
  size_t object = 0;  // of those given
  size_t kernel = 0;
  double distance_m = 0;
};

// Where the ray has lost half of its light: the median depth. A kernel stands in its way where its density
// along the ray is highest. Nothing when more than half passes. `direction` is unit; what is nearer than
// `near_m` is not there. Cost: one pass over the kernels, a few nanoseconds each.
std::optional<PickedKernel> pick_kernel(std::span<const DrawnObject> objects, const Eigen::Vector3d& origin_m,
                                        const Eigen::Vector3d& direction, double near_m = 0.05);

}  // namespace livegs

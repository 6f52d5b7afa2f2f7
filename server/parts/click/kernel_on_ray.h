// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// The kernel in which transmittance along a ray falls under a half, by the greatest response of each kernel.
// The ray is in the frame of the asset; `direction` is unit. One pass over all kernels. Any thread.
std::optional<uint32_t> kernel_on_ray(const GaussianAsset& asset, const Eigen::Vector3d& origin_m,
                                      const Eigen::Vector3d& direction);

}  // namespace livegs

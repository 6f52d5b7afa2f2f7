// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/kernel_positions.h"
#include "splat/passes/order_depth.h"

namespace livegs {

// Depth keys of kernels (ordered_key), with the bits of the native renderer. `covariances_m2`: columns xx xy
// xz yy yz zz of an environment, whose kernels are ordered by their far side; null: other objects.
void fill_depth_keys(const OrderView& view, const KernelPositions& positions,
                     const std::array<std::vector<float>, 6>* covariances_m2, std::span<uint32_t> keys);

}  // namespace livegs

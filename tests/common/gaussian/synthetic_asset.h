// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Kernels with all properties uniformly distributed in ranges that every format supports: positions within
// +-2, log-scales -9 to 1, opacity logits +-5, sh_dc +-1.5, further coefficients +-0.9, any rotation.
// Identical for a seed on every machine.
GaussianAsset synthetic_asset(size_t count, int sh_degree, uint64_t seed);

}  // namespace livegs

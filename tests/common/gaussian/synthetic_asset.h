// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Kernels with every property drawn evenly from a range that all formats can hold: positions within +-2,
// log-scales -9 to 1, opacity logits +-5, sh_dc +-1.5, further coefficients +-0.9, rotations all over. The
// same for a seed on any machine.
GaussianAsset synthetic_asset(size_t count, int sh_degree, uint64_t seed);

}  // namespace livegs

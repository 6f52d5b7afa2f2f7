// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Converts between the frame of .spz (x right, y up, z back) and that of GaussianAsset (x right, y down, z
// forward): a half turn about x. Turns positions, rotations and harmonics in place. The operation is its own
// inverse and preserves all magnitudes.
void turn_half_about_x(GaussianAsset& asset);

}  // namespace livegs

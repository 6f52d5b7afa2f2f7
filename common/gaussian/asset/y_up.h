// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Converts between the frame of .spz (x right, y up, z back) and that of GaussianAsset (x right, y down, z
// forward): a half turn about x. The turn is its own inverse and changes no magnitude.
void turn_half_about_x(GaussianAsset& asset);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"

namespace livegs {

// Assigns room kernels at the rim of a thing to the thing. Such kernels are off all planes of the room,
// within a voxel or two of kernels of the thing, and of the same colour. Their pixels are undecided, because
// few views see them, or because they have the colour of the support. Repeated outwards a few times.
// Deterministic.
void claim_rim(const GaussianAsset& asset, RoomParts& found);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"

namespace livegs {

// Gives kernels of the room to a thing that they continue: they are off all planes of the room, within a
// voxel or two of kernels of the thing and of their colour. Few views see them, or at a foot they have the
// colour of the support, so that their pixels did not decide. Repeated outwards a few times. Deterministic.
void claim_rim(const GaussianAsset& asset, RoomParts& found);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parts/find/thing_voxels.h"

namespace livegs {

// A label picture for each view: the thing number + 1 of the voxel behind each pixel, 0 elsewhere. Voxels
// reach down to a little above the support only. Pixels below that, near a thing, belong to it if their
// colour is likelier among the colours of the thing's foot than among those of the support around it (8^3
// cells).
std::vector<std::vector<uint16_t>> pixel_labels(std::span<const RoomView> views, const ThingVoxels& found,
                                                const RoomPlanes& planes, const PartScale& scale);

}  // namespace livegs

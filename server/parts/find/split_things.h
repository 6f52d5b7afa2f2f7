// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parts/find/thing_voxels.h"

namespace livegs {

// Separates touching things. Voxels are grouped into flat patches of one colour. Patches that meet in a flat
// or convex edge are merged. A concave edge separates patches, since solids meet in concave edges (Stein et
// al. 2014, Object partitioning using local convexity). A small part, such as a handle, is merged with a
// neighbour of the same colours. Deterministic.
void split_things(ThingVoxels& found);

}  // namespace livegs

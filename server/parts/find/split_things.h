// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parts/find/thing_voxels.h"

namespace livegs {

// Separates things that touch. Voxels are grouped to flat patches of one colour. Patches that meet in a flat
// or convex edge grow together; across a concave edge they stay apart, since solids meet in concave edges
// (Stein et al. 2014, Object partitioning using local convexity). A small part of the same colours, such as a
// handle, goes back to its neighbour. Deterministic.
void split_things(ThingVoxels& found);

}  // namespace livegs

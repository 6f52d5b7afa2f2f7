// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "physics/lattice/lattice.h"

// Which boxes of material hang together.

namespace livegs {

// Pairs i < j of BodyExtent::boxes, ascending. Two boxes are linked when the gap between them along every
// axis is at most half a box edge (touching edges and corners count, jittered grids stay whole, and a missing
// row of voxels is a gap). Parts that nothing links are joined to the rest by links across the gaps between
// them, the narrowest first, up to `max_gap_m`: a body of dust is still one body.
std::vector<std::pair<uint32_t, uint32_t>> link_boxes(const BodyExtent& extent, double max_gap_m);

}  // namespace livegs

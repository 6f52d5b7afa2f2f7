// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "physics/lattice/lattice.h"

// Connectivity of the boxes of material.

namespace livegs {

// Pairs i < j of BodyExtent::boxes, ascending. Two boxes are linked if the gap between them along every axis
// is at most half a box edge. Shared edges and corners count as links and jittered grids stay connected, but
// a missing row of voxels is a gap. Separate parts are then linked to the rest across the gaps between them,
// narrowest first, up to `max_gap_m`, so that scattered points still form one body.
std::vector<std::pair<uint32_t, uint32_t>> link_boxes(const BodyExtent& extent, double max_gap_m);

}  // namespace livegs

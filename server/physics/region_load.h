// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "physics/body_region.h"
#include "physics/lattice.h"

// Where a region's traction acts: the outer face of the region's material, as points of the lattice with an area each.

namespace livegs {

struct LoadPoint {
  EmbeddedPoint point;
  double area_m2;
};

// The face lies across the shortest edge of the region's box cut to the body's bounds (object axes; of equal edges the
// first); it is the one of the two nearer to the body's bound. Each box of material in the region gives its volume
// over the region's thickness as area, so the areas sum to the face's where the region is full; exact where the
// lattice lies along the object's axes. Empty when the region holds no material.
std::vector<LoadPoint> load_points(const BodyExtent& extent, const Lattice& lattice, const BodyRegion& region);

}  // namespace livegs

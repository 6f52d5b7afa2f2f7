// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "physics/body_region.h"
#include "physics/lattice/lattice.h"

// Where a region's traction acts: the outer face of the region's material, as points of the lattice with an
// area each.

namespace livegs {

struct LoadPoint {
  EmbeddedPoint point;
  double area_m2;
};

// The face lies across the shortest edge of the region's box cut to the body's bounds (object axes; of equal
// edges the first); it is the one of the two nearer to the body's bound. The areas are the volume that the
// region holds of the mesh, over its thickness: so they sum to the face's where the region is full. Of a list
// of points it is that of the boxes, exact where the lattice lies along the object's axes. Empty when the
// region holds no material.
std::vector<LoadPoint> load_points(const ParticleSet& particles, const BodyExtent& extent,
                                   const Lattice& lattice, const BodyRegion& region);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "physics/body_region.h"
#include "physics/lattice/lattice.h"

// Distribution of a region's traction: the outer face of its material, as lattice points with areas.

namespace livegs {

struct LoadPoint {
  EmbeddedPoint point;
  double area_m2;
};

// The face lies across the shortest edge of the region's box, clipped to the body's bounds (object axes; the
// first of equal edges). Of the two faces it is the one nearer to the body's bound. The areas are the volume
// of the mesh in the region over the region's thickness, so they sum to the area of the face if the region is
// full. For a list of points the boxes are used instead of the mesh; this is exact if the lattice is along
// the object's axes. Empty if the region holds no material.
std::vector<LoadPoint> load_points(const ParticleSet& particles, const BodyExtent& extent,
                                   const Lattice& lattice, const BodyRegion& region);

}  // namespace livegs

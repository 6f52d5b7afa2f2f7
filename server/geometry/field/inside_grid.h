// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/field/regular_grid.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Returns for each node of the grid 1 if the mesh winds around it, else 0. Overlapping parts count once;
// inward-facing cavities are outside. Uses scanlines along x. Neighbouring triangles share one formula for
// each edge, so a line through an edge or a vertex is counted exactly once. For a closed mesh, no error
// spreads along a scanline, whatever the rounding.
std::vector<uint8_t> nodes_inside(const TriangleMesh& mesh, const RegularGrid& grid);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/field/regular_grid.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// For each node of the grid 1 where the mesh winds around it, else 0; overlapping pieces count once,
// inward-facing cavities are outside. Scanlines along x. Whether a line meets a triangle is decided edge by
// edge with one formula that both neighbours share, so a line through an edge or a vertex is counted neither
// twice nor never: with a closed mesh no error runs along a line, whatever the rounding.
std::vector<uint8_t> nodes_inside(const TriangleMesh& mesh, const RegularGrid& grid);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/field/regular_grid.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Regions of a mesh too thin for a grid. A board between two layers of nodes contains no node, and a board of
// two cells contains a single layer.
struct UnresolvedWallCells {
  std::vector<uint8_t> is_thin;  // by the cell's lowest node; empty: none
  double thinnest_m = 0.0;  // approximate thickness of the thinnest wall with parallel faces; infinity: none
};
// Marks the cells near two opposed faces that are less than about two and a half cells apart through the
// material.
UnresolvedWallCells unresolved_wall_cells(const TriangleMesh& mesh, const RegularGrid& grid);

}  // namespace livegs

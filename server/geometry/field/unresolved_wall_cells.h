// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/field/regular_grid.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Where a mesh is thinner than a grid can tell: a board between two layers of nodes has none of them inside,
// and one of two cells has a single layer.
struct UnresolvedWallCells {
  std::vector<uint8_t> is_thin;  // by the cell's lowest node; empty: nowhere
  double thinnest_m = 0.0;       // about the thinnest wall with parallel faces among them; infinite: none
};
// Marks the cells that have two faces near, turned away from each other, that are less than some two and a
// half cells apart through the material.
UnresolvedWallCells unresolved_wall_cells(const TriangleMesh& mesh, const RegularGrid& grid);

}  // namespace livegs

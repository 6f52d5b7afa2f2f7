// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "geometry/fracture/clip_to_cell.h"

// Private to the geometry room.

namespace livegs {

// A connected part of a clipped cell: an outer surface and the surfaces of cavities inside it.
struct CellPart {
  uint32_t cell = 0;
  std::vector<std::array<uint32_t, 3>> triangles;  // indices into the cell's vertices
  using Face = ClippedCell::Face;
  std::vector<Face> faces;
};

// Returns the parts in order of their first face. Parts of zero or negative volume outside all other parts
// (rounding) are merged with the first one.
std::vector<CellPart> connected_parts(const ClippedCell& cell, uint32_t number);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "geometry/fracture/clip_to_cell.h"

// Inside the room.

namespace livegs {

// A connected part of what a cell holds: an outer surface, with the surfaces of hollows inside it.
struct CellPart {
  uint32_t cell = 0;
  std::vector<std::array<uint32_t, 3>> triangles;  // over the cell's vertices
  using Face = ClippedCell::Face;
  std::vector<Face> faces;
};

// In order of first face. Parts of no or negative volume that no other part encloses (rounding) go with the
// first.
std::vector<CellPart> connected_parts(const ClippedCell& cell, uint32_t number);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <utility>

#include "physics/lattice/lattice.h"
#include "physics/lattice/virtual_nodes.h"

namespace livegs {

// Sets LatticeCell::thin. The shape is that of the connected material in a cube of one cell width about the
// cell's centroid. The cell's own content is not enough: the fragment of a sheet in a corner of a cell does
// not show the shape of the sheet. `origin_m` is the position of lattice coordinates 0, lattice axes.
void find_thin_shapes(const BodyExtent& extent, std::span<const std::pair<uint32_t, uint32_t>> links,
                      std::span<const BoxInCell> entries, std::span<const uint32_t> cell_of_entry,
                      const Eigen::Vector3d& origin_m, Lattice& lattice);

}  // namespace livegs

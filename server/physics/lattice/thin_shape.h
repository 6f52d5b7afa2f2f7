// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <utility>

#include "physics/lattice/lattice.h"
#include "physics/lattice/virtual_nodes.h"

namespace livegs {

// Sets LatticeCell::thin. The shape is that of the material within half a cell of the cell's own, as far as
// it hangs together there: what a plane of the lattice leaves of a sheet in the corner of a cell says little
// of the sheet. `origin_m`: where the lattice's coordinates 0 stand, lattice axes.
void find_thin_shapes(const BodyExtent& extent, std::span<const std::pair<uint32_t, uint32_t>> links,
                      std::span<const BoxInCell> entries, std::span<const uint32_t> cell_of_entry,
                      const Eigen::Vector3d& origin_m, Lattice& lattice);

}  // namespace livegs

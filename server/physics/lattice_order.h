// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <tuple>

#include "physics/lattice.h"

// The order of cells in a Lattice: by parity colour, then by z, y, x.

namespace livegs {

using LatticeKey = std::tuple<int, int, int>;

inline LatticeKey lattice_key(const Eigen::Vector3i& c) { return {c.z(), c.y(), c.x()}; }

inline int colour_of(const Eigen::Vector3i& c) { return (c.x() & 1) | (c.y() & 1) << 1 | (c.z() & 1) << 2; }

inline auto cell_order(const LatticeCell& cell) {
  return std::make_tuple(colour_of(cell.coordinates), lattice_key(cell.coordinates));
}

inline Eigen::Vector3i corner_offset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }

}  // namespace livegs

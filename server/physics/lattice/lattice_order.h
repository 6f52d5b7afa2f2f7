// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <tuple>

// Ordering and colouring of lattice coordinates.

namespace livegs {

using LatticeKey = std::tuple<int, int, int>;

inline LatticeKey lattice_key(const Eigen::Vector3i& c) { return {c.z(), c.y(), c.x()}; }

// Bit 0: x is odd, bit 1: y, bit 2: z. Cells of one parity share no corner.
inline int colour_of(const Eigen::Vector3i& c) { return (c.x() & 1) | (c.y() & 1) << 1 | (c.z() & 1) << 2; }

inline Eigen::Vector3i corner_offset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// The thinnest wall, in parts of the longest side, that the grid of hollow_mesh can tell from nothing.
inline constexpr double kMinWallShare = 1.0 / 64.0;

// A closed solid made into a closed wall around air: its surface, and one inside it that faces the hollow.
// The inner one is where the distance to the outer is `wall_m`, by marching tetrahedra (Doi and Koide 1991)
// on a grid of 32 to 96 cells along the longest side; its volume is right within a few hundredths. Any
// thread; the same bits for the same input. Errors: a wall thinner than kMinWallShare, or so thick that
// nothing is left inside.
Result<TriangleMesh> hollow_mesh(const TriangleMesh& mesh, double wall_m);

// Whether parts of a closed mesh face inwards, and enclose a tenth or more of what the others do: it is a
// wall around air.
bool has_hollow(const TriangleMesh& mesh);

}  // namespace livegs

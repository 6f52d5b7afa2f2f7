// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Minimum wall thickness relative to the longest side that the grid of hollow_mesh can resolve.
inline constexpr double kMinWallShare = 1.0 / 64.0;

// Turns a closed solid into a closed wall around a cavity: its surface, and an inner surface at the distance
// `wall_m` that faces the cavity. Uses marching tetrahedra (Doi and Koide 1991) on a grid of 32 to 96 cells
// along the longest side. The volume is accurate to a few per cent. Any thread; deterministic. Errors: a wall
// thinner than kMinWallShare, or so thick that no cavity remains.
Result<TriangleMesh> hollow_mesh(const TriangleMesh& mesh, double wall_m);

// Returns whether parts of a closed mesh face inwards and enclose at least a tenth of the volume of the
// others.
bool has_hollow(const TriangleMesh& mesh);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/rigid_islands.h"

namespace livegs {

// Number of sub-intervals of an island's substep; contacts are recomputed in each. Greater than 1 only if two
// free, non-spherical bodies approach by several times their thickness per substep. A stopped corner then
// turns a body over within the substep, and contacts found at its start miss the faces that arrive later.
// Islands with joints or very many contacts are not subdivided.
int ccd_substeps(const RigidIsland& island, double duration_s);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/rigid_islands.h"

namespace livegs {

// In how many equal parts an island's substep is done, each with contacts of its own: 1 but where two free
// bodies that are not balls come at each other by many times their thickness in a substep. A corner that is
// stopped there turns the body over within the substep, and contacts that were found at its start say nothing
// of the face that comes then. What joints hold, and islands of very many contacts, are not cut up.
int ccd_substeps(const RigidIsland& island, double duration_s);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/rigid_islands.h"

namespace livegs {

// Factor on the number of solver steps of an island with a heavy body on a light one: 1 to 4. Contact
// stiffness grows with the square of the step rate: a body under r times its mass sinks in proportion to r /
// factor², and weight propagates down a stack in fewer substeps. Islands with joints or very many contacts
// use 1.
int mass_ratio_substeps(const RigidIsland& island, const Eigen::Vector3d& gravity_m_s2);

}  // namespace livegs

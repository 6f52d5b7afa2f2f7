// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/rigid/rigid_islands.h"

namespace livegs {

// How many times as many solver steps an island takes as one in which nothing heavy lies on something light:
// 1 to 4. Contacts are as stiff as the square of the step rate, so that what bears r times its mass sinks by
// r / (steps)², and weight finds its way down a stack of light things in as many steps fewer. What joints
// hold, and islands of very many contacts, take no more.
int mass_ratio_substeps(const RigidIsland& island, const Eigen::Vector3d& gravity_m_s2);

}  // namespace livegs

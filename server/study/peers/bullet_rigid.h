// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// Bullet's rigid bodies: btDiscreteDynamicsWorld, sequential impulse with 10 iterations and split impulse, as
// it comes. One step of Bullet a substep. Set: no damping, no sleep unless asked for, planes give three
// contact points at once (setPlaneConvexMultipointIterations) instead of one a step. Collision margins as
// they come: within the box, at most a tenth of its shortest half edge, and 4 cm.
std::unique_ptr<RigidSolver> make_bullet_rigid(const RigidSetup& setup, const RigidConditions& conditions);

}  // namespace livegs::study

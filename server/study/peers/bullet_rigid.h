// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// Bullet's rigid bodies: btDiscreteDynamicsWorld, sequential impulse with 10 iterations and split impulse,
// default settings. One step per substep. Changed settings: no damping, sleep only on request, and three
// contact points with a plane at once (setPlaneConvexMultipointIterations) instead of one per step. Default
// collision margins: within the box, at most a tenth of its shortest half edge, and 4 cm.
std::unique_ptr<RigidSolver> make_bullet_rigid(const RigidSetup& setup, const RigidConditions& conditions);

}  // namespace livegs::study

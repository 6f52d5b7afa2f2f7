// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// Our World, as it comes. Boxes are meshes of twelve triangles, balls are balls.
std::unique_ptr<RigidSolver> make_livegs_rigid(const RigidSetup& setup, const RigidConditions& conditions);

}  // namespace livegs::study

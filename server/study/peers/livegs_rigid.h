// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/rigid_solver.h"

namespace livegs::study {

// The LiveGS World with default settings. Boxes are meshes of twelve triangles, balls are spheres.
std::unique_ptr<RigidSolver> make_livegs_rigid(const RigidSetup& setup, const RigidConditions& conditions);

}  // namespace livegs::study

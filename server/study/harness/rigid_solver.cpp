// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/rigid_solver.h"

namespace livegs::study {

Result<void> RigidSolver::add_soft(const SoftPart&) {
  return Error{ErrorCode::Unavailable,
               "rigid scene: contact with soft bodies is not supported for this engine"};
}

Result<bool> RigidSolver::broken(size_t) const {
  return Error{ErrorCode::Unavailable, "rigid scene: contact impulses are not available for this engine"};
}

}  // namespace livegs::study

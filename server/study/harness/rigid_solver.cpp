// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/rigid_solver.h"

namespace livegs::study {

Result<void> RigidSolver::add_soft(const SoftPart&) {
  return Error{ErrorCode::Unavailable, "soft bodies of this engine are not connected to rigid ones"};
}

Result<bool> RigidSolver::broken(size_t) const {
  return Error{ErrorCode::Unavailable, "contact impulses of this engine are not connected"};
}

}  // namespace livegs::study

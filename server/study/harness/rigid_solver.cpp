// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/rigid_solver.h"

namespace livegs::study {

Result<void> RigidSolver::add_soft(const SoftPart&) {
  return Error{ErrorCode::Unavailable, "soft bodies are not connected to rigid bodies in this engine"};
}

Result<bool> RigidSolver::broken(size_t) const {
  return Error{ErrorCode::Unavailable, "contact impulses are not available in this engine"};
}

}  // namespace livegs::study

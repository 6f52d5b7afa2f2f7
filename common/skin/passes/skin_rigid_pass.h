// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"
#include "skin/kernels/skin_rigid_layout.h"

namespace livegs {

// The pass that moves kernels with their rigid bodies: position R x + t, covariance R S Rᵀ. Same result as
// skin_kernels for DriverKind::Rigid. One item per kernel. Buffers: RestKernelRow, RigidPoseRow,
// PosedKernelRow.
const Pass& skin_rigid_pass();

}  // namespace livegs

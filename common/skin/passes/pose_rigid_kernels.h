// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"
#include "skin/passes/pose_rigid_kernels_layout.h"

namespace livegs {

// The pass that moves kernels with their rigid bodies: position R x + t, covariance R S Rᵀ, what skin_kernels
// computes for DriverKind::Rigid. An item is a kernel. Buffers: RestKernelRow, RigidPoseRow, PosedKernelRow.
const Pass& pose_rigid_kernels_pass();

}  // namespace livegs

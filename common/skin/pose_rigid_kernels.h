// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"
#include "skin/pose_rigid_kernels_layout.h"

namespace livegs {

// The pass that moves kernels with their rigid bodies: position R x + t, covariance R S Rᵀ, what skin_kernels
// computes for DriverKind::Rigid. Buffers: RigidKernelRow at rest, RigidPoseRows, RigidKernelRow posed.
const Pass& pose_rigid_kernels_pass();

// The buffers of one dispatch. `rest` and `posed` hold kernel_count rows at least, `poses` body_count.
struct PoseRigidKernels {
  BufferId rest{};
  BufferId poses{};
  BufferId posed{};
  uint32_t kernel_count = 0;
  uint32_t body_count = 0;  // at least 1; a kernel of a body past the end moves with the last
};

Result<void> dispatch_pose_rigid_kernels(Backend& backend, const PoseRigidKernels& work);

}  // namespace livegs

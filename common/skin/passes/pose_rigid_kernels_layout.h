// SPDX-License-Identifier: Apache-2.0

// What the pass pose_rigid_kernels reads besides RestKernelRow, for C++ and GLSL alike; it writes
// PosedKernelRow. Scalars only, so that std430 and C++ lay the members out in the same way.

#ifdef __cplusplus
#pragma once
#endif
#include "gaussian/asset/posed_kernel_row.h"
#include "skin/kernels/rest_kernel_row.h"
#ifdef __cplusplus
namespace livegs {
#endif

// world_from_body: rows of [R | t], t in metres; and world_from_asset, the rotation alone.
struct RigidPoseRow {
  float r00;
  float r01;
  float r02;
  float x_m;
  float r10;
  float r11;
  float r12;
  float y_m;
  float r20;
  float r21;
  float r22;
  float z_m;
  float qx;
  float qy;
  float qz;
  float qw;
};

struct PoseRigidKernelsConstants {
  uint kernel_count;
  uint first_kernel;  // where their rest rows begin; the posed rows begin at 0
  uint body_count;    // a kernel of a body past the end moves with the last
};

#ifdef __cplusplus
static_assert(sizeof(RigidPoseRow) == 64 && alignof(RigidPoseRow) == 4);
static_assert(sizeof(PoseRigidKernelsConstants) == 12);
}  // namespace livegs
#endif

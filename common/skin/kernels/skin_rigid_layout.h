// SPDX-License-Identifier: Apache-2.0

// Input of the pass skin_rigid besides RestKernelRow; its output is PosedKernelRow. Shared by C++ and GLSL.
// Members are scalars, so std430 and C++ have the same layout.

#ifdef __cplusplus
#pragma once
#endif
#include "gaussian/asset/posed_kernel_row.h"
#include "skin/kernels/rest_kernel_row.h"
#ifdef __cplusplus
namespace livegs {
#endif

// world_from_body as rows of [R | t], t in metres; and world_from_asset, the rotation only.
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

struct SkinRigidConstants {
  uint kernel_count;
  uint first_kernel;  // start of their rest rows; the posed rows start at 0
  uint body_count;    // a kernel with a body index past the end moves with the last body
};

#ifdef __cplusplus
static_assert(sizeof(RigidPoseRow) == 64 && alignof(RigidPoseRow) == 4);
static_assert(sizeof(SkinRigidConstants) == 12);
}  // namespace livegs
#endif

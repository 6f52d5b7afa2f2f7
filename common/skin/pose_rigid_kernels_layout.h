// SPDX-License-Identifier: Apache-2.0

// What the pass pose_rigid_kernels reads and writes, for C++ and GLSL alike. Scalars only, so that std430 and C++
// lay the members out in the same way.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

// A kernel at rest in its body's frame, or posed in the world frame.
struct RigidKernelRow {
  float x_m;
  float y_m;
  float z_m;
  uint body;  // index into the poses; posed rows carry it on
  float sxx_m2;
  float sxy_m2;
  float sxz_m2;
  float syy_m2;
  float syz_m2;
  float szz_m2;
  float spare0;  // posed rows: 0
  float spare1;
};

// world_from_body: rows of [R | t], t in metres.
struct RigidPoseRows {
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
};

struct PoseRigidKernelsConstants {
  uint kernel_count;
  uint body_count;
};

#ifdef __cplusplus
static_assert(sizeof(RigidKernelRow) == 48 && alignof(RigidKernelRow) == 4);
static_assert(sizeof(RigidPoseRows) == 48 && alignof(RigidPoseRows) == 4);
static_assert(sizeof(PoseRigidKernelsConstants) == 8);
}  // namespace livegs
#endif

// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "skin/pose_rigid_kernels_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Rest { RigidKernelRow rest[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Poses { RigidPoseRows poses[]; };
layout(std430, set = 0, binding = 2) writeonly restrict buffer Posed { RigidKernelRow posed[]; };
layout(push_constant) uniform Constants { PoseRigidKernelsConstants constants; };

void main() {
  const uint k = gl_GlobalInvocationID.x;
  if (k >= constants.kernel_count) return;
  const RigidKernelRow kernel = rest[k];
  const RigidPoseRows p = poses[min(kernel.body, constants.body_count - 1)];

  // GLSL takes columns: this is R transposed, so v * turn is R v, and its products below are written that way round.
  const mat3 turn = mat3(p.r00, p.r01, p.r02, p.r10, p.r11, p.r12, p.r20, p.r21, p.r22);
  const mat3 s = mat3(kernel.sxx_m2, kernel.sxy_m2, kernel.sxz_m2, kernel.sxy_m2, kernel.syy_m2, kernel.syz_m2,
                      kernel.sxz_m2, kernel.syz_m2, kernel.szz_m2);
  const vec3 position = vec3(kernel.x_m, kernel.y_m, kernel.z_m) * turn + vec3(p.x_m, p.y_m, p.z_m);
  const mat3 covariance = transpose(turn) * s * turn;

  posed[k] = RigidKernelRow(position.x, position.y, position.z, kernel.body, covariance[0][0], covariance[1][0],
                            covariance[2][0], covariance[1][1], covariance[2][1], covariance[2][2], 0.0, 0.0);
}

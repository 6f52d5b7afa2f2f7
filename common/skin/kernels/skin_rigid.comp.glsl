// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "skin/kernels/skin_rigid_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Rest { RestKernelRow rest[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Poses { RigidPoseRow poses[]; };
layout(std430, set = 0, binding = 2) writeonly restrict buffer Posed { PosedKernelRow posed[]; };
layout(push_constant) uniform Constants { SkinRigidConstants constants; };

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= constants.kernel_count) return;
  const RestKernelRow k = rest[constants.first_kernel + i];
  const RigidPoseRow p = poses[min(k.driver, constants.body_count - 1)];

  // GLSL matrices are built from columns: this is R transposed, so v * turn is R v; the products below are
  // transposed accordingly.
  const mat3 turn = mat3(p.r00, p.r01, p.r02, p.r10, p.r11, p.r12, p.r20, p.r21, p.r22);
  const mat3 s = mat3(k.sxx_m2, k.sxy_m2, k.sxz_m2, k.sxy_m2, k.syy_m2, k.syz_m2, k.sxz_m2, k.syz_m2, k.szz_m2);
  const vec3 position = vec3(k.at_x, k.at_y, k.at_z) * turn + vec3(p.x_m, p.y_m, p.z_m);
  const mat3 covariance = transpose(turn) * s * turn;

  posed[i] = PosedKernelRow(position.x, position.y, position.z, covariance[0][0], covariance[1][0], covariance[2][0],
                            covariance[1][1], covariance[2][1], covariance[2][2], p.qx, p.qy, p.qz, p.qw);
}

// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "skin/kernels/skin_lattice_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Rest { RestKernelRow rest[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Cells { uint cells[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Nodes { vec4 nodes[]; };
layout(std430, set = 0, binding = 3) writeonly restrict buffer Posed { PosedKernelRow posed[]; };
layout(push_constant) uniform Constants { SkinLatticeConstants constants; };

#include "skin/kernels/limit_deformation.glsl"

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= constants.kernel_count) return;
  const RestKernelRow k = rest[constants.first_kernel + i];
  const uint cell = min(k.driver, constants.cell_count - 1);

  const vec3 local = vec3(k.at_x, k.at_y, k.at_z);
  const vec3 at = clamp(local, 0.0, 1.0);
  // Summed term by term as in the CPU function, because F decides how a flattened cell is drawn.
  precise vec3 far = 1.0 - at;
  precise vec4 position = vec4(0.0);
  precise vec4 dx = vec4(0.0);
  precise vec4 dy = vec4(0.0);
  precise vec4 dz = vec4(0.0);
  for (uint corner = 0; corner < 8; ++corner) {
    precise float across = ((corner & 2u) == 0 ? far.y : at.y) * ((corner & 4u) == 0 ? far.z : at.z);
    precise float weight = ((corner & 1u) == 0 ? far.x : at.x) * across;
    const uint node = 4 * min(cells[8 * cell + corner], constants.node_count - 1);
    position += weight * nodes[node];
    dx += weight * nodes[node + 1];
    dy += weight * nodes[node + 2];
    dz += weight * nodes[node + 3];
  }
  const LimitedDeformation limited = limit_deformation(mat3(dx.xyz, dy.xyz, dz.xyz));
  const mat3 f = limited.gradient;

  vec3 place = position.xyz;
  const vec3 offset = constants.cell_width_m * (local - at);
  // outside its cell: the first cell width moves with F at that point, the rest with the mean F of the body
  if (offset != vec3(0.0)) {
    const mat3 body = transpose(mat3(constants.body_xx, constants.body_xy, constants.body_xz, constants.body_yx,
                                     constants.body_yy, constants.body_yz, constants.body_zx, constants.body_zy,
                                     constants.body_zz));
    const float near_share = min(1.0, constants.cell_width_m / length(offset));
    place += f * (near_share * offset) + body * ((1.0 - near_share) * offset);
  }

  const mat3 s = mat3(k.sxx_m2, k.sxy_m2, k.sxz_m2, k.sxy_m2, k.syy_m2, k.syz_m2, k.sxz_m2, k.syz_m2, k.szz_m2);
  const mat3 covariance = f * s * transpose(f);
  const vec4 a = limited.rotation;
  const vec3 b = vec3(constants.qx, constants.qy, constants.qz);
  const vec3 turn = a.w * b + constants.qw * a.xyz + cross(a.xyz, b);
  posed[i] = PosedKernelRow(place.x, place.y, place.z, covariance[0][0], covariance[1][0], covariance[2][0],
                            covariance[1][1], covariance[2][1], covariance[2][2], turn.x, turn.y, turn.z,
                            a.w * constants.qw - dot(a.xyz, b));
}

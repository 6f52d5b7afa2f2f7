// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/project_splats_layout.h"
#include "splat/shadow/shadow_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Views { FrameViews views; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Posed { PosedKernelRow posed[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Looks { KernelLookRow looks[]; };
layout(std430, set = 0, binding = 3) readonly restrict buffer Bands { uint bands_of[]; };
layout(std430, set = 0, binding = 4) writeonly restrict buffer Left { SplatRow left_rows[]; };
layout(std430, set = 0, binding = 5) writeonly restrict buffer Right { SplatRow right_rows[]; };
layout(std430, set = 0, binding = 6) writeonly restrict buffer Keys { uint keys[]; };
layout(std430, set = 0, binding = 7) readonly restrict buffer Shadows { uint shadow_words[]; };
layout(push_constant) uniform Constants { ProjectSplatsConstants constants; };

#include "splat/project/precise.glsl"
#include "splat/project/spherical_harmonics.glsl"
#include "splat/shadow/shadow.glsl"

const float kHalfLog2E = 0.72134752;
const uint kNoKey = 0xffffffffu;  // kSortDroppedKey

uint ordered_key(float value) {
  const uint bits = floatBitsToUint(value);
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

vec3 turned_back(PosedKernelRow k, vec3 v) {  // conj(q) v q
  const vec3 axis = vec3(-k.qx, -k.qy, -k.qz);
  const vec3 twice = 2.0 * cross(axis, v);
  return v + k.qw * twice + cross(axis, twice);
}

// Product of the covariance and a row.
vec3 spread(PosedKernelRow k, vec3 r) {
  return vec3(k.sxx_m2 * r.x + k.sxy_m2 * r.y + k.sxz_m2 * r.z,
              k.sxy_m2 * r.x + k.syy_m2 * r.y + k.syz_m2 * r.z,
              k.sxz_m2 * r.x + k.syz_m2 * r.y + k.szz_m2 * r.z);
}

// Shared by both eyes: the cofactors of the covariance, computed without cancellation.
struct Cofactors {
  float xx, xy, xz, yy, yz, zz;
};

Cofactors cofactors(PosedKernelRow k) {
  return Cofactors(product_difference(k.syy_m2, k.szz_m2, k.syz_m2, k.syz_m2),
                   product_difference(k.sxz_m2, k.syz_m2, k.sxy_m2, k.szz_m2),
                   product_difference(k.sxy_m2, k.syz_m2, k.sxz_m2, k.syy_m2),
                   product_difference(k.sxx_m2, k.szz_m2, k.sxz_m2, k.sxz_m2),
                   product_difference(k.sxy_m2, k.sxz_m2, k.sxx_m2, k.syz_m2),
                   product_difference(k.sxx_m2, k.syy_m2, k.sxy_m2, k.sxy_m2));
}

// Position and size of the kernel for the eye, without colour. False if nothing of it is visible.
bool project(EyeView eye, PosedKernelRow k, Cofactors c, float kernel_log2_opacity, out SplatRow row) {
  row = SplatRow(0.0, 0.0, 0.0, 0.0, 0.0, kCulled_log2, 0.0, 0.0, 0.0);
  const vec3 offset = vec3(k.x_m, k.y_m, k.z_m) - vec3(eye.x_m, eye.y_m, eye.z_m);
  const vec3 axis_x = vec3(eye.xx, eye.xy, eye.xz);
  const vec3 axis_y = vec3(eye.yx, eye.yy, eye.yz);
  const vec3 axis_z = vec3(eye.zx, eye.zy, eye.zz);
  const float z = dot(axis_z, offset);
  if (!(z > eye.near_m)) return false;
  const float slope_x = dot(axis_x, offset) / z;
  const float slope_y = dot(axis_y, offset) / z;
  const vec3 row_x = (eye.focal_x_px / z) * (axis_x - clamp(slope_x, eye.min_slope_x, eye.max_slope_x) * axis_z);
  const vec3 row_y = (eye.focal_y_px / z) * (axis_y - clamp(slope_y, eye.min_slope_y, eye.max_slope_y) * axis_z);

  const vec3 across = spread(k, row_x);
  const float sharp_xx = dot(across, row_x);
  const float sharp_yy = dot(spread(k, row_y), row_y);
  float xy = dot(across, row_y);
  // Determinant of J S Jᵀ by Cauchy-Binet: n adj(S) nᵀ, with n the cross product of the rows.
  const vec3 n = cross(row_x, row_y);
  const vec3 spread_n = vec3(c.xx * n.x + c.xy * n.y + c.xz * n.z, c.xy * n.x + c.yy * n.y + c.yz * n.z,
                             c.xz * n.x + c.yz * n.y + c.zz * n.z);
  const float sharp_det = max(0.0, dot(spread_n, n));
  float det = sharp_det + kSplatLowPass_px2 * (sharp_xx + sharp_yy) + kSplatLowPass_px2 * kSplatLowPass_px2;
  float xx = sharp_xx + kSplatLowPass_px2;
  float yy = sharp_yy + kSplatLowPass_px2;
  if (!(det > 0.0 && det < 1e37 && xx > 0.0 && yy > 0.0)) return false;

  float log2_opacity = kernel_log2_opacity;
  if (eye.near_m > 0.0 && z < 3.0 * eye.near_m) log2_opacity += log2_of((z - eye.near_m) / (2.0 * eye.near_m));
  if (constants.antialiased != 0) {
    if (!(sharp_det > 0.0)) return false;
    log2_opacity += 0.5 * log2_of(sharp_det / det);
  }
  if (!(log2_opacity >= -kSplatLog2Of255)) return false;

  const float rim = (log2_opacity + kSplatLog2Of255) / kHalfLog2E;  // dᵀ S⁻¹ d where alpha is 1/255
  if (eye.max_radius_px > 0.0) {
    const float half_gap = 0.5 * (xx - yy);
    const float longest = rim * (0.5 * (xx + yy) + sqrt(half_gap * half_gap + xy * xy));
    const float most = eye.max_radius_px * eye.max_radius_px;
    if (longest > most) {
      const float shrink = most / longest;
      xx *= shrink;
      xy *= shrink;
      yy *= shrink;
      det *= shrink * shrink;
    }
  }
  if (eye.min_log2_contribution > kCulled_log2 &&
      log2_opacity + 0.5 * log2_of(det) + kLog2OfTwoPi < eye.min_log2_contribution) {
    return false;
  }
  const float centre_x = eye.focal_x_px * slope_x + eye.centre_x_px;
  const float centre_y = eye.focal_y_px * slope_y + eye.centre_y_px;
  const float reach_x = sqrt(rim * xx);
  const float reach_y = sqrt(rim * yy);
  if (!(centre_x + reach_x >= 0.0 && centre_x - reach_x <= eye.width_px && centre_y + reach_y >= 0.0 &&
        centre_y - reach_y <= eye.height_px)) {
    return false;
  }
  const float scale = sqrt(kHalfLog2E);
  const float root_yy = sqrt(yy);
  const float root_det = sqrt(det);
  row.centre_x_px = centre_x;
  row.centre_y_px = centre_y;
  row.across_x = scale * (root_yy / root_det);
  row.across_y = -scale * (xy / (root_yy * root_det));
  row.down_y = scale / root_yy;
  row.log2_opacity = log2_opacity;
  return true;
}

vec3 colour_towards(EyeView eye, PosedKernelRow k, uint index) {
  const KernelLookRow look = looks[constants.first_kernel + index];
  vec3 sum = vec3(0.5) + kShDc * vec3(look.dc_red, look.dc_green, look.dc_blue);
  if (constants.sh_degree > 0) {
    const vec3 offset = vec3(k.x_m, k.y_m, k.z_m) - vec3(eye.x_m, eye.y_m, eye.z_m);
    sum += bands_towards(normalize(turned_back(k, offset)), constants.sh_degree,
                         (constants.first_kernel + index) * constants.sh_row_words);
  }
  return max(sum, vec3(0.0));
}

void main() {
  const uint i = gl_GlobalInvocationID.x;
  if (i >= constants.kernel_count) return;
  const PosedKernelRow k = posed[constants.first_posed + i];
  const Cofactors c = cofactors(k);
  const uint row_place = constants.first_row + i;
  bool seen = false;
  float light = 1.0;
  for (uint e = 0; e < views.eye_count; ++e) {
    SplatRow row;
    if (project(views.eye[e], k, c, looks[constants.first_kernel + i].log2_opacity, row)) {
      if (!seen) light = shadow_light(vec3(k.x_m, k.y_m, k.z_m), constants.object_id);
      const vec3 colour = light * colour_towards(views.eye[e], k, i);
      row.red = colour.x;
      row.green = colour.y;
      row.blue = colour.z;
      seen = true;
    }
    if (e == 0) {
      left_rows[row_place] = row;
    } else {
      right_rows[row_place] = row;
    }
  }
  const vec3 from_origin =
      vec3(k.x_m, k.y_m, k.z_m) - vec3(views.origin_x_m, views.origin_y_m, views.origin_z_m);
  vec3 towards = vec3(views.axis_x, views.axis_y, views.axis_z);
  float depth = dot(towards, from_origin);
  if (views.by_distance != 0) {
    depth = sqrt(dot(from_origin, from_origin));
    towards = from_origin / max(depth, 1e-9);
  }
  if (constants.order_bias > 0.0) depth += constants.order_bias * sqrt(max(0.0, dot(spread(k, towards), towards)));
  keys[constants.first_key + i] = seen ? ordered_key(depth) : kNoKey;
}

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "gaussian/asset/posed_kernel_row.h"

// The depth by which kernels are sorted, in floats: the CPU function of the end of main() in
// project_splats.comp.glsl, also used by the browser client.

namespace livegs {

struct Row3 {
  float x, y, z;
};

inline float dot(const Row3& a, const Row3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Product of the covariance and a row.
inline Row3 spread(const PosedKernelRow& k, const Row3& r) {
  return {k.sxx_m2 * r.x + k.sxy_m2 * r.y + k.sxz_m2 * r.z, k.sxy_m2 * r.x + k.syy_m2 * r.y + k.syz_m2 * r.z,
          k.sxz_m2 * r.x + k.syz_m2 * r.y + k.szz_m2 * r.z};
}

struct OrderView {
  Row3 origin_m;     // between the eyes
  Row3 axis;         // unit length, into the picture
  bool by_distance;  // distance from the origin; otherwise depth along the axis
};

// Position of the kernel relative to the origin, m; its depth, m, without bias.
inline float order_depth(const OrderView& view, const Row3& from_origin) {
  return view.by_distance ? std::sqrt(dot(from_origin, from_origin)) : dot(view.axis, from_origin);
}

// With a bias of `order_bias` standard deviations along the view (kEnvironmentOrderBias), if it is above 0.
inline float order_depth(const OrderView& view, const PosedKernelRow& k, float order_bias) {
  const Row3 from_origin{k.x_m - view.origin_m.x, k.y_m - view.origin_m.y, k.z_m - view.origin_m.z};
  const float depth = order_depth(view, from_origin);
  if (!(order_bias > 0.0f)) return depth;
  Row3 towards = view.axis;
  if (view.by_distance) {
    const float length = std::max(depth, 1e-9f);
    towards = {from_origin.x / length, from_origin.y / length, from_origin.z / length};
  }
  return depth + order_bias * std::sqrt(std::max(0.0f, dot(spread(k, towards), towards)));
}

}  // namespace livegs

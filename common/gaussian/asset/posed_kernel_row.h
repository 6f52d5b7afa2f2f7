// SPDX-License-Identifier: Apache-2.0

// The pose of a kernel as passes exchange it: skinning writes it, projection reads it. Shared by C++ and
// GLSL. Members are scalars, so std430 and C++ have the same layout.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

// One kernel of PosedKernels, in the world frame.
struct PosedKernelRow {
  float x_m;
  float y_m;
  float z_m;
  float sxx_m2;
  float sxy_m2;
  float sxz_m2;
  float syy_m2;
  float syz_m2;
  float szz_m2;
  float qx;  // world_from_asset
  float qy;
  float qz;
  float qw;
};

#ifdef __cplusplus
static_assert(sizeof(PosedKernelRow) == 52 && alignof(PosedKernelRow) == 4);
}  // namespace livegs
#endif

// SPDX-License-Identifier: Apache-2.0

// Rest data of a kernel as read by the skinning passes. Shared by C++ and GLSL. Members are scalars, so
// std430 and C++ have the same layout.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

// A kernel at rest. Rigid: in the frame of its body. Lattice: covariance in the axes of the lattice.
struct RestKernelRow {
  uint driver;  // Rigid: the body. Lattice: the cell
  float at_x;   // Rigid: position, m. Lattice: local coordinates, 0..1 inside the cell
  float at_y;
  float at_z;
  float sxx_m2;
  float sxy_m2;
  float sxz_m2;
  float syy_m2;
  float syz_m2;
  float szz_m2;
};

#ifdef __cplusplus
static_assert(sizeof(RestKernelRow) == 40 && alignof(RestKernelRow) == 4);
}  // namespace livegs
#endif

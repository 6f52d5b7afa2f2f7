// SPDX-License-Identifier: Apache-2.0

// Input of the pass skin_lattice besides RestKernelRow; its output is PosedKernelRow. Shared by C++ and GLSL.
//
// A cell is eight uints, the nodes at its corners: bit 0 of a corner is +x, bit 1 +y, bit 2 +z. A node is
// four vec4: its position, m, then the deformation of the body there, dx/dX, dx/dY and dx/dZ, with X Y Z
// along the axes of the lattice. The fourth lanes are unused and 0.

#ifdef __cplusplus
#pragma once
#endif
#include "gaussian/asset/posed_kernel_row.h"
#include "skin/kernels/rest_kernel_row.h"
#ifdef __cplusplus
namespace livegs {
#endif

const uint kLatticeNodeFloats = 16;

struct SkinLatticeConstants {
  uint kernel_count;
  uint first_kernel;  // start of their rest rows; the posed rows start at 0
  uint cell_count;    // a kernel with a cell index past the end uses the last cell
  uint node_count;    // likewise
  float cell_width_m;
  // lattice_from_asset, rotation only.
  float qx;
  float qy;
  float qz;
  float qw;
  // Mean deformation of the body, by rows. Haze beyond one cell width from its cell moves with it.
  float body_xx;
  float body_xy;
  float body_xz;
  float body_yx;
  float body_yy;
  float body_yz;
  float body_zx;
  float body_zy;
  float body_zz;
};

// Maximum stretch of a kernel; the minimum is its inverse. Same limits as in skin_kernels.h.
const uint kKernelStretchLimit = 4;

#ifdef __cplusplus
static_assert(sizeof(SkinLatticeConstants) == 72);
}  // namespace livegs
#endif

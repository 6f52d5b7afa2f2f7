// SPDX-License-Identifier: Apache-2.0

// What the pass skin_lattice reads besides RestKernelRow, for C++ and GLSL alike; it writes PosedKernelRow.
//
// Cells are eight uints each, the nodes at their corners; bit 0 of a corner is +x, bit 1 +y, bit 2 +z. Nodes
// are four vec4 each: where the node is, m; then how the body deforms there, dx/dX, dx/dY and dx/dZ with X Y
// Z along the lattice's axes. The fourth lanes are spare, 0.

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
  uint first_kernel;  // where their rest rows begin; the posed rows begin at 0
  uint cell_count;    // a kernel of a cell past the end rides in the last
  uint node_count;    // likewise
  float cell_width_m;
  // lattice_from_asset, the rotation alone.
  float qx;
  float qy;
  float qz;
  float qw;
  // How the body deforms as a whole, by rows: what haze rides on beyond a cell width from its cell.
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

// A kernel is stretched to this at most and shrunk to one over it, as skin_kernels.h has it.
const uint kKernelStretchLimit = 4;

#ifdef __cplusplus
static_assert(sizeof(SkinLatticeConstants) == 72);
}  // namespace livegs
#endif

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"
#include "skin/kernels/skin_lattice_layout.h"

namespace livegs {

// The pass that moves kernels with the lattice that embeds them. Same result as skin_kernels for
// DriverKind::Lattice. One item per kernel. Buffers: RestKernelRow, cells, nodes, PosedKernelRow
// (skin_lattice_layout.h).
const Pass& skin_lattice_pass();

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/driver_frame.h"
#include "skin/kernels/kernel_bindings.h"
#include "skin/kernels/lattice_skinning.h"
#include "skin/kernels/rest_kernel_row.h"
#include "skin/kernels/skin_rigid_layout.h"
#include "skin/rest_body.h"

// The input of the skinning passes, packed on the host: for DeviceSkin and for the browser client, which
// skins with shaders of its own. Preconditions of all: the bindings came from the rest body; the drivers fit
// it (check_drivers); its kind is Rigid or Lattice.

namespace livegs {

// The rest rows of kernels [first, first + count) of `kept`, or of all kernels if `kept` is empty.
void pack_rest_rows(const KernelBindings& bindings, std::span<const uint32_t> kept, size_t first,
                    std::span<RestKernelRow> rows);

// Drivers of one object as the passes read them, 64 bytes each. Only the array of its kind is filled.
struct DriverRows {
  std::vector<NodeState> nodes;      // Lattice
  LatticeBody lattice;               // Lattice: constants of the pass
  std::vector<RigidPoseRow> bodies;  // Rigid
};
DriverRows pack_driver_rows(const RestBody& rest, const KernelBindings& bindings,
                            const ObjectDrivers& drivers);

}  // namespace livegs

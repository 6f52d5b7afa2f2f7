// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "skin/driver_rows.h"
#include "skin/rest_body.h"

// Positions of kernels without their covariances, for depth keys of clients that skin with shaders.

namespace livegs {

// The part of a RestKernelRow that its position depends on; the same members.
struct PlacedKernel {
  uint32_t driver;
  float at_x, at_y, at_z;
};

// Positions in columns, m.
struct KernelPositions {
  std::vector<float> x_m, y_m, z_m;
  size_t size() const { return x_m.size(); }
};

// The kernels of a lattice that are outside of their cells, ascending: an input of skin_positions.
std::vector<uint32_t> kernels_outside(std::span<const PlacedKernel> kernels);

// Positions of all kernels, with the bits that the passes compute. `outside`: Lattice: kernels_outside();
// Rigid: empty. Preconditions: the rows fit `rest`, and each driver of a kernel is one of its cells or
// bodies.
void skin_positions(const RestBody& rest, std::span<const PlacedKernel> kernels,
                    std::span<const uint32_t> outside, const DriverRows& rows, KernelPositions& positions);

}  // namespace livegs

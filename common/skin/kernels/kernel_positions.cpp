// SPDX-License-Identifier: Apache-2.0
#include "skin/kernel_positions.h"

#include <array>

#include "core/parallel_for.h"
#include "skin/kernels/driver_skinning.h"
#include "skin/kernels/lattice_skinning.h"

namespace livegs {
namespace {

// Four floats in one register (vector extension of GCC and clang; SIMD of WebAssembly).
using Four = float __attribute__((vector_size(16)));

Four four(float value) { return Four{value, value, value, value}; }

bool is_within_cell(const PlacedKernel& kernel) {
  const auto within = [](float x) { return x >= 0.0f && x <= 1.0f; };
  return within(kernel.at_x) && within(kernel.at_y) && within(kernel.at_z);
}

// The weighted sum of interpolate() in skin_lattice.cpp: calls add(corner, weight) for each corner. Written
// out, so that no compiler keeps the weights in memory.
template <class Add>
void each_corner(const Four& at, const Add& add) {
  const float x = at[0], y = at[1], z = at[2], x_low = 1.0f - x, y_low = 1.0f - y, z_low = 1.0f - z;
  const float yz[4] = {y_low * z_low, y * z_low, y_low * z, y * z};
  add(0, four(x_low * yz[0]));
  add(1, four(x * yz[0]));
  add(2, four(x_low * yz[1]));
  add(3, four(x * yz[1]));
  add(4, four(x_low * yz[2]));
  add(5, four(x * yz[2]));
  add(6, four(x_low * yz[3]));
  add(7, four(x * yz[3]));
}

void store(const Four& position_m, size_t kernel, KernelPositions& positions) {
  positions.x_m[kernel] = position_m[0];
  positions.y_m[kernel] = position_m[1];
  positions.z_m[kernel] = position_m[2];
}

// Local coordinates of the nearest point of the cell.
Four clamped(const PlacedKernel& kernel) {
  const Four at = {kernel.at_x, kernel.at_y, kernel.at_z, 0.0f}, none = four(0.0f), all = four(1.0f);
  const Four low = at < none ? none : at;
  return low > all ? all : low;
}

void skin_in_cells(const RestBody& rest, std::span<const PlacedKernel> kernels, const DriverRows& rows,
                   KernelPositions& positions) {
  // The corners of each cell together: a kernel then reads two cache lines instead of nine.
  std::vector<std::array<Four, 8>> corners(rest.cells.size());
  for (size_t i = 0; i < corners.size(); ++i) {
    for (size_t c = 0; c < 8; ++c) {
      const auto& x = rows.nodes[rest.cells[i][c]].position_and_x;
      corners[i][c] = Four{x[0], x[1], x[2], 0.0f};
    }
  }
  parallel_for(kernels.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const std::array<Four, 8>& cell = corners[kernels[k].driver];
      Four sum = four(0.0f);
      each_corner(clamped(kernels[k]), [&](size_t c, const Four& weight) { sum += weight * cell[c]; });
      store(sum, k, positions);
    }
  });
}

// Moves kernels outside of their cells from the nearest point to their places.
void skin_beyond_cells(const RestBody& rest, std::span<const PlacedKernel> kernels,
                       std::span<const uint32_t> outside, const DriverRows& rows,
                       KernelPositions& positions) {
  parallel_for(outside.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t k = outside[i];
      const std::array<uint32_t, 8>& cell = rest.cells[kernels[k].driver];
      const Four at = clamped(kernels[k]);
      Four x = four(0.0f), y = x, z = x;  // columns of the gradient
      const auto four_of = [](const float* from) { return Four{from[0], from[1], from[2], from[3]}; };
      each_corner(at, [&](size_t c, const Four& weight) {
        const NodeState& node = rows.nodes[cell[c]];
        x += weight * four_of(node.position_and_x.data() + 4);
        y += weight * four_of(node.y_and_z.data());
        z += weight * four_of(node.y_and_z.data() + 4);
      });
      Eigen::Matrix3f gradient;
      gradient << x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2];
      limit_gradient(gradient);
      const Eigen::Array3f beyond(kernels[k].at_x - at[0], kernels[k].at_y - at[1], kernels[k].at_z - at[2]);
      Eigen::Vector3f position_m(positions.x_m[k], positions.y_m[k], positions.z_m[k]);
      move_beyond_cell(beyond, gradient, rows.lattice, position_m);
      store(Four{position_m.x(), position_m.y(), position_m.z(), 0.0f}, k, positions);
    }
  });
}

}  // namespace

std::vector<uint32_t> kernels_outside(std::span<const PlacedKernel> kernels) {
  std::vector<uint32_t> outside;
  for (uint32_t k = 0; k < kernels.size(); ++k) {
    if (!is_within_cell(kernels[k])) outside.push_back(k);
  }
  return outside;
}

void skin_positions(const RestBody& rest, std::span<const PlacedKernel> kernels,
                    std::span<const uint32_t> outside, const DriverRows& rows, KernelPositions& positions) {
  for (std::vector<float>* column : {&positions.x_m, &positions.y_m, &positions.z_m})
    column->resize(kernels.size());
  if (rest.kind == DriverKind::Lattice) {
    skin_in_cells(rest, kernels, rows, positions);
    skin_beyond_cells(rest, kernels, outside, rows, positions);
    return;
  }
  // The sums of skin_rigid_row().
  parallel_for(kernels.size(), kSkinBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const PlacedKernel& kernel = kernels[k];
      const RigidPoseRow& p = rows.bodies[kernel.driver];
      positions.x_m[k] = p.r00 * kernel.at_x + p.r01 * kernel.at_y + p.r02 * kernel.at_z + p.x_m;
      positions.y_m[k] = p.r10 * kernel.at_x + p.r11 * kernel.at_y + p.r12 * kernel.at_z + p.y_m;
      positions.z_m[k] = p.r20 * kernel.at_x + p.r21 * kernel.at_y + p.r22 * kernel.at_z + p.z_m;
    }
  });
}

}  // namespace livegs

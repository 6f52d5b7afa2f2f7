// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/cell_stiffness.h"
#include "physics/lanes.h"
#include "physics/lattice.h"

// One Gauss-Seidel sweep over all cells: colour by colour, four cells of one colour at a time. Cells of one colour
// share no node, so the four are independent and the order inside a colour does not matter.

namespace livegs {

// x, y, z and the inverse mass; of a correction x, y, z and 0.
struct alignas(32) NodeLanes {
  Lanes value;
};

// Four cells; unused places hold cells without stiffness on a spare node that nothing else uses.
struct CellBatch {
  std::array<std::array<uint32_t, 4>, 8> nodes;  // by corner, then place
  Lanes centroid[3];
  Lanes mobility[6];          // G: 11, 22, 33, 23, 13, 12
  Lanes mode_coupling[4][3];
  Lanes rotation[4];          // w, x, y, z: world from lattice, kept from substep to substep
  Lanes inverse_four_widths;  // 1 / (4 a)
};
struct BatchGains {
  Lanes shear[21];  // H, upper triangle by rows
  Lanes volume_compliance;
  Lanes mode[4][3];
};

// The place of each cell (lattice order) among the batches: batch * 4 + place.
struct CellBatches {
  std::vector<CellBatch> batches;
  std::vector<uint32_t> places;
  Eigen::Quaterniond rotation(size_t cell) const;
};

// `spare_node` is one past the lattice's nodes. Fixed cells, whose nodes never move, are left out (place UINT32_MAX).
CellBatches make_cell_batches(const Lattice& lattice, std::span<const CellBlock> blocks,
                              std::span<const double> inverse_masses, const Eigen::Quaterniond& rotation,
                              uint32_t spare_node);
std::vector<BatchGains> make_batch_gains(const CellBatches& batches, std::span<const CellGains> gains);

// How far from rest the worst cell was.
struct SweepReport {
  double strain_squared = 0.0;  // |S - I|²
  double volume_ratio = 1.0;    // least det F
};

// `predicted` is read, `corrections` are added to; both have the spare node at the end.
SweepReport sweep_cells(std::span<CellBatch> batches, std::span<const BatchGains> gains,
                        std::span<const NodeLanes> predicted, std::span<NodeLanes> corrections);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/elastic/cells/kernels/cell_kernels.h"
#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/lattice/lattice.h"

// The cells of a lattice in the order of the sweep: batches of eight cells of one parity colour, which share
// no node. Full cells (of the body's own material, between full nodes), cut cells and thin cells (with a
// sheet or cord) have separate batches.

namespace livegs {

// Position of a cell: batch `index` of its kind, lane `lane`. A held cell, with nodes that never move, is in
// no batch.
struct CellPlace {
  enum class Kind : uint8_t { Held, Full, Cut, Thin } kind = Kind::Held;
  uint8_t lane = 0;
  uint32_t index = 0;
};

struct CellBatches {
  std::vector<FullCells> full;
  std::vector<CutCells> cut;
  std::vector<ThinCells> thin;
  CellColours colours{};
  std::vector<CellPlace> places;  // by lattice cell
  bool paired = false;            // corners 2k and 2k + 1 are consecutive nodes in every cell

  Eigen::Quaterniond rotation(size_t cell) const;  // identity for a held cell
  void set_rotations(const Eigen::Quaterniond& rotation);
  size_t bytes() const;
};

// Materials of the cells. The moduli of a cell with several materials are means by volume.
struct CellMaterials {
  std::vector<IsotropicMaterial> materials;  // of the body; indexed by MaterialShare::material
  IsotropicMaterial of(const LatticeCell& cell) const;
};

// `spare_nodes` is the first of eight massless nodes at the corners of a cell; unused lanes refer to them.
// `rotations` (by cell) are the initial rotations of the sweep. Without `may_be_full` (plastic flow) no cell
// is full; without `may_be_thin` none is thin.
CellBatches make_cell_batches(const Lattice& lattice, std::span<const double> inverse_masses,
                              std::span<const Eigen::Quaterniond> rotations, uint32_t spare_nodes,
                              bool may_be_full, bool may_be_thin);

// Gains of all cells for one effective step length `step_s`.
struct GaussSeidelGains {
  FullGains full{};
  std::vector<CutGains> cut;
  std::vector<ThinGains> thin;
  size_t bytes() const { return cut.capacity() * sizeof(CutGains) + thin.capacity() * sizeof(ThinGains); }
};
GaussSeidelGains make_gauss_seidel_gains(const Lattice& lattice, const CellBatches& batches,
                                         std::span<const double> inverse_masses,
                                         const CellMaterials& materials, bool compensate, double step_s);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/elastic/cells/kernels/cell_kernels.h"
#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/lattice/lattice.h"

// The cells of a lattice as the sweep wants them: eight of one parity colour at a time, so that they share no
// node, and the many cells that are full, of the body's own material and between full nodes apart from the
// others, and from those that hold a thin sheet or cord.

namespace livegs {

// Where a cell is: eights[index], place `lane`. A held cell, whose nodes never move, is nowhere.
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
  std::vector<CellPlace> places;   // by cell of the lattice
  double full_inverse_mass = 0.0;  // of the nodes around full cells
  bool paired = false;             // corners 2k and 2k + 1 are consecutive nodes in every cell

  Eigen::Quaterniond rotation(size_t cell) const;  // identity for a held cell
  void set_rotations(const Eigen::Quaterniond& rotation);
  size_t bytes() const;
};

// What a cell is made of: of several materials in one cell, the mean of their moduli by volume.
struct CellMaterials {
  std::vector<IsotropicMaterial> materials;  // of the body: MaterialShare::material is an index into it
  IsotropicMaterial of(const LatticeCell& cell) const;
};

// `spare_nodes` is the first of eight nodes that stand at the corners of a cell and have no mass: unused
// places hold them. `rotations` by cell are where the sweep's own rotations start. Without `may_be_full`, as
// when cells flow, none is full; without `may_be_thin` none is thin.
CellBatches make_cell_batches(const Lattice& lattice, std::span<const double> inverse_masses,
                              std::span<const Eigen::Quaterniond> rotations, uint32_t spare_nodes,
                              bool may_be_full, bool may_be_thin);

// Gains of all cells for a step that divides by `step_s`.
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

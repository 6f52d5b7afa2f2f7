// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

#include "physics/elastic/cells/kernels/cell_lanes.h"

// The inner loop of the `cells` solver over cells, as a plain function over flat arrays; node_kernels.h has
// those over nodes. Single precision, lengths relative to an origin near the body.

namespace livegs {

// Eight cells of one parity colour, which share no node. Unused places hold cells without stiffness on spare
// nodes. A cell inside the body, full and between nodes of full mass, has no constants of its own.
struct FullCells {
  uint32_t nodes[8][8];  // by corner, then place
  Lanes rotation[4];     // w, x, y, z: world from lattice, kept from substep to substep
};
struct CutCells {
  uint32_t nodes[8][8];
  Lanes rotation[4];
  Lanes centroid[3];
  Lanes mobility[6];  // G: 11, 22, 33, 23, 13, 12
  Lanes mode_coupling[4][3];
};
// A cell that holds a thin sheet or cord (thin_cell.h).
struct ThinCells {
  uint32_t nodes[8][8];
  Lanes rotation[4];
  Lanes centroid[3];
  Lanes mobility;  // tr G; 0 in unused places
  Lanes fold;      // the squared strain that its faces have, over the squared amplitude of its modes, 1/m²
                   // (thin_cell_fold)
};
// Where the material has flowed its strain is S - D, D the plastic part in Mandel's notation, and its modes
// are at rest at amplitudes of their own, m.
struct PlasticCells {
  Lanes part[6];
  Lanes mode_rest[4][3];
};

// What a step multiplies by (cell_stiffness.h), for one h_e.
struct FullGains {
  float mobility, shear, volume_compliance, mode[4][3];
};
struct CutGains {
  Lanes shear[21];  // H, upper triangle by rows, Mandel
  Lanes volume_compliance;
  Lanes mode[4][3];
};
// Impulses are -gain times what the cell measures: mean strain (Mandel), then the amplitudes of its modes.
inline constexpr int kThinMeasures = 18;
struct ThinGains {
  Lanes gain[kThinMeasures * (kThinMeasures + 1) / 2];  // upper triangle by rows
  Lanes relief;  // what is left of it without the compensation of the sweep; at most 1
};

// One colour after another, or from the last to the first: a sweep in a fixed order pulls a body sideways.
inline constexpr int kCellColours = 16;  // parities, and more for cells that stand at one place
struct CellColours {
  // Eights of cells by colour.
  size_t full_begin[kCellColours + 1], cut_begin[kCellColours + 1], thin_begin[kCellColours + 1];
};
struct GaussSeidelArrays {
  const NodeLanes* predicted = nullptr;
  NodeLanes* corrections = nullptr;
  FullCells* full = nullptr;
  CutCells* cut = nullptr;
  ThinCells* thin = nullptr;
  const PlasticCells* plastic = nullptr;       // one a CutCells, or nullptr
  const PlasticCells* thin_plastic = nullptr;  // one a ThinCells, or nullptr
  const CutGains* gains = nullptr;             // one a CutCells
  const ThinGains* thin_gains = nullptr;       // one a ThinCells
  FullGains full_gains{};
  float inverse_four_widths = 0;  // 1 / (4 a), 1/m
  bool backward = false;
  bool paired = false;  // nodes[2k + 1] is nodes[2k] + 1 in every place
};
// How far from rest the worst cell was.
struct GaussSeidelReport {
  float strain_squared = 0;  // |S - I|², of thin cells with bending
  float bent_squared = 0;    // with bending, counted as the strain of a full cell's faces
  float volume_ratio = 1;    // least det F
};
GaussSeidelReport gauss_seidel_pass(const GaussSeidelArrays& arrays, const CellColours& colours);

// What full cells of one material store, J (cell_energy of cell_stiffness.h), of nodes where they are between
// steps. Strains of 1e-6 and less are lost in rounding.
struct FullModuli {
  float shear_j, lambda_j, mode_n_m[4][3];  // V mu, V lambda, and the stiffness of the modes
};
double full_cell_energy(const FullCells* begin, const FullCells* end, const NodeLanes* positions,
                        const FullModuli& moduli, float inverse_four_widths);
// Likewise of eight cut cells in which nothing has flowed; 0 in unused places.
struct CutModuli {
  Lanes shear_j, lambda_j, mode_n_m[4][3];
};
double cut_cell_energy(const CutCells& cells, const NodeLanes* positions, const CutModuli& moduli,
                       float inverse_four_widths);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

#include "physics/elastic/cells/kernels/cell_lanes.h"

// Inner loop of the `cells` solver over cells, as a plain function on flat arrays; node_kernels.h has the
// loops over nodes. Single precision, lengths relative to an origin near the body.

namespace livegs {

// Strains |S - I|² of a cell (thin cells: including bending). From the first on, a body takes steps of first
// order and its energy is limited; from the second on, a cell counts as overstrained (shape recovery in
// contact or after plastic flow, stuck contacts).
inline constexpr float kStrainedSquared = 0.25f, kOverstrainedSquared = 1.0f;

// Eight cells of one parity colour, which share no node. Unused lanes are cells without stiffness on the
// spare nodes. A full cell between nodes of full mass has no constants of its own.
struct FullCells {
  uint32_t nodes[8][8];  // by corner, then lane
  Lanes rotation[4];     // w, x, y, z: world from lattice; persistent between substeps
};
struct CutCells {
  uint32_t nodes[8][8];
  Lanes rotation[4];
  Lanes centroid[3];
  Lanes mobility[6];  // G: 11, 22, 33, 23, 13, 12
  Lanes mode_coupling[4][3];
};
// Cells with a thin sheet or cord (plate_cell.h).
struct ThinCells {
  uint32_t nodes[8][8];
  Lanes rotation[4];
  Lanes centroid[3];
  Lanes mobility;  // tr G; 0 in unused lanes
  // Squared face strain over squared mode amplitude, 1/m² (thin_cell_fold).
  Lanes fold;
};
// Plastic state: the strain is S - D, with D the plastic part (Mandel), and the modes have rest amplitudes,
// m.
struct PlasticCells {
  Lanes part[6];
  Lanes mode_rest[4][3];
};

// Gains for one h_e (cell_stiffness.h).
struct FullGains {
  float mobility, shear, volume_compliance, mode[4][3];
};
struct CutGains {
  Lanes shear[21];  // H, upper triangle by rows, Mandel
  Lanes volume_compliance;
  Lanes mode[4][3];
};
// Impulses are -gain times the 18 measures of the cell: mean strain (Mandel), then the mode amplitudes.
struct ThinGains {
  Lanes gain[18 * 19 / 2];  // upper triangle by rows
};

// Colours are swept in ascending order, or in descending order with `backward`: a fixed order causes a
// sideways drift.
struct CellColours {
  size_t full_begin[17], cut_begin[17], thin_begin[17];  // batch ranges by colour
};
struct GaussSeidelArrays {
  const NodeLanes* predicted = nullptr;
  NodeLanes* corrections = nullptr;
  FullCells* full = nullptr;
  CutCells* cut = nullptr;
  ThinCells* thin = nullptr;
  const PlasticCells* plastic = nullptr;       // one per CutCells, or nullptr
  const PlasticCells* thin_plastic = nullptr;  // one per ThinCells, or nullptr
  const CutGains* gains = nullptr;             // one per CutCells
  const ThinGains* thin_gains = nullptr;       // one per ThinCells
  FullGains full_gains{};
  float inverse_four_widths = 0;  // 1 / (4 a), 1/m
  bool backward = false;
  bool paired = false;  // nodes[2k + 1] is nodes[2k] + 1 in every lane
};
// Largest deviation from rest over all cells.
struct GaussSeidelReport {
  float strain_squared = 0;  // |S - I|², for thin cells including bending
  float bent_squared = 0;    // including bending, as the strain of a full cell's faces
  float volume_ratio = 1;    // smallest det F
};
GaussSeidelReport gauss_seidel_pass(const GaussSeidelArrays& arrays, const CellColours& colours);

// Stored energy of full cells of one material, J (cell_energy in cell_stiffness.h), at the positions between
// steps. Strains of about 1e-6 and below are lost to rounding.
struct FullModuli {
  float shear_j, lambda_j, mode_n_m[4][3];  // V mu, V lambda, and the mode stiffness
};
double full_cell_energy(const FullCells* begin, const FullCells* end, const NodeLanes* positions,
                        const FullModuli& moduli, float inverse_four_widths);
// The same for eight cut cells without plastic flow; 0 in unused lanes.
struct CutModuli {
  Lanes shear_j, lambda_j, mode_n_m[4][3];
};
double cut_cell_energy(const CutCells& cells, const NodeLanes* positions, const CutModuli& moduli,
                       float inverse_four_widths);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

// How fine a lattice and how short a step a body needs (elastic-study.md 2.7). A sweep carries a stress one cell a
// substep, so the reachable stiffness is rho (Co a / h)²: at equal cost it goes with the eighth power of the cell
// width. Hence coarse cells and short steps.

namespace livegs {

// More substeps a frame than this are not taken; a stiffer body is clipped to what they reach.
inline constexpr int kMaxBodySubsteps = 32;

struct CellDemand {
  Eigen::Vector3d size_m;       // edges of the body's bounding box, lattice axes
  double particle_edge_m = 0;   // cells below 1.5 of it would be emptier than the material
  double youngs_modulus_pa = 0, poisson_ratio = 0, density_kg_m3 = 0;
  double rate_hz = 0;
  int substeps = 1;             // the scene's, a frame
  double cell_width_m = 0;      // > 0: given, and only the substeps are chosen
};

struct CellChoice {
  double cell_width_m = 0;
  int substeps = 1;             // a frame; a multiple of the scene's
  double courant = 0;           // sqrt(E/rho) h / a of the modulus that is simulated
  double youngs_modulus_pa = 0; // the one that is simulated
  bool clipped = false;         // it is less than the one asked for
};

// The largest Courant number at which statics, dynamics and contact are all within their stated errors.
double courant_limit(double poisson_ratio, double cells_across);

CellChoice choose_cells(const CellDemand& demand);

}  // namespace livegs

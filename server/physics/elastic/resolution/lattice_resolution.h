// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

#include "physics/elastic_body.h"
#include "physics/lattice/lattice.h"

// How fine a lattice and how short a step a body needs (elastic-study.md 2.7). A sweep carries a stress one
// cell a substep, so the reachable stiffness is rho (Co a / h)²: at equal cost it goes with the eighth power
// of the cell width. Hence coarse cells and short steps.

namespace livegs {

// More substeps a frame than this are not taken; a stiffer body is clipped to what they reach. While it is
// struck hard it takes impact_substeps times as many.
inline constexpr int kMaxBodySubsteps = 32;

struct ResolutionRequest {
  Eigen::Vector3d size_m;      // edges of the body's bounding box, lattice axes
  double middle_side_m = 0;    // of its material, where size_m is larger; 0: of size_m
  double particle_edge_m = 0;  // cells below 1.5 of it would be emptier than the material
  double youngs_modulus_pa = 0, poisson_ratio = 0, density_kg_m3 = 0;
  double rate_hz = 0;
  int substeps = 1;                             // the scene's, a frame
  double cell_width_m = 0;                      // > 0: given, and only the substeps are chosen
  double max_node_substeps = kMaxNodeSubsteps;  // a frame: wider cells, then fewer substeps, keep to it
  double max_courant = 1.0;                     // below courant_limit where more is asked of it
};
// Of a body whose whole boundary is moved: where nodes cannot move, colours share a stress unequally by the
// square of the step, and within this the inside follows within 2 %.
inline constexpr double kBoundaryCourant = 0.4;

struct LatticeResolution {
  double cell_width_m = 0;
  int substeps = 1;              // a frame; a multiple of the scene's
  double courant = 0;            // sqrt(E/rho) h / a of the modulus that is simulated
  double youngs_modulus_pa = 0;  // the one that is simulated
  bool clipped = false;          // it is less than the one asked for
  bool over_budget =
      false;  // cells are wider than they should be for their thickness, or it would cost too much
  double node_substeps = 0;  // a frame, by its bounding box
  int impact_substeps = 1;   // in place of one, while the body is struck hard; 1 ... 4
  // sqrt(E/rho) of what is simulated.
  double wave_speed_m_s(double rate_hz) const { return courant * rate_hz * substeps * cell_width_m; }
};

// The largest Courant number, sqrt(E/rho) h / a, at which dynamics and contact are within their stated
// errors, with the thinnest side `cells_across` cells wide; statics too in bodies of eight cells along or
// more.
double courant_limit(double poisson_ratio, double cells_across);

LatticeResolution choose_resolution(const ResolutionRequest& request);

// What is known before anything runs about the stiffness that a lattice shows, E_app / E
// (elastic-study.md 2.4, 3).
//
// Ybar, the mean by volume of Y = 1 / (E V h_e² A0): the material's compliance in units of what one sweep can
// do, A0 a third of the trace of G = sum w_i g_i g_iᵀ. It covers thickness and the placing of the lattice in
// one number: 2 / Co² (Co with h_e) inside a wide body, a quarter of it one cell across. Cells that are held
// do not count. Infinite for a lattice without any other.
double mean_pass_compliance(const Lattice& lattice, std::span<const double> inverse_masses_per_kg,
                            double youngs_modulus_pa, double step_s);

// The most that one compensated sweep a substep reaches: 4.15 rho a² (cells / nodes) / h_e². Just above it; a
// modulus far above it shows half of that.
double modulus_ceiling_pa(const Lattice& lattice, double density_kg_m3, double step_s);

// What a body shows more than E when it is pulled by its ends, as part of E: 2 Co² / n, with Co = sqrt(E/rho)
// h_e / a and n cells from end to end. What a sweep takes from a cell's stiffness is what the cells beyond it
// undo, and that is given back to every cell alike; but beyond the ends there is a force and no cell. Within
// 1 % of measured figures up to 6 % (one to eight cells, nu 0 to .45). In the middle half of four cells or
// more there is none of it. The same across, by the cells there.
double end_excess(double courant, double cells_along);
// With more of it a body is not called exact; Poisson's ratio at .45 is then 0.02 off too.
inline constexpr double kMaxEndExcess = 0.0405;

// What is thinner than half a cell and lies obliquely in the lattice, or of which only points on its surface
// are known, bends from so much to so much of what it should: strips and cords in turned lattices, the sample
// plant and the captured palm (README.md). With more than this part of its volume in such cells a body is not
// called exact.
inline constexpr double kMaxThinPart = 0.05, kThinBendsFrom = 0.2, kThinBendsTo = 6.5;
double thin_part(const Lattice& lattice, bool loose);

struct BandRequest {
  double mean_pass_compliance = 0.0;  // Ybar
  double poisson_ratio = 0.0;
  double cells_across = 4.0, cells_along = 16.0;  // of the thinnest side and the longest
  double courant = 0.0;                           // with h_e
  double ceiling_ratio = 1.0;                     // modulus_ceiling_pa / E
};
struct ModulusBand {
  ElasticBand band;
  double ratio_low, ratio_high;  // E_app / E of a body pulled along its longest side
  double ratio_across = 0.0;  // the most that it shows pulled or pressed across its shortest one; 0: unknown
};
// Exact (within 5 % when measured, 4 as predicted) above Ybar 4 and .9 / (1 - 2 nu) where the end excess is
// small; a band down to 1.1, as wide as the measured figures spread there; clipped below, between 0.45
// and 1.1 of the ceiling in long bodies; unknown where so few cells along take so long a step that what pulls
// at the ends never lets them rest. (A body that chooses for itself gets to neither of the last two: it
// lowers E to what eight cells along would show exactly, and says so.)
ModulusBand band_of(const BandRequest& request);

}  // namespace livegs

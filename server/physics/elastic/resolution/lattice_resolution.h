// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/elastic_body.h"
#include "physics/lattice/lattice.h"

// Choice of cell width and step length of a body. A sweep carries stress by one cell per substep, so the
// reachable stiffness is rho (Co a / h)². The cost is nodes times substeps, 1 / (a³ h): at equal cost the
// stiffness grows with the eighth power of the cell width. Coarse cells and short steps are therefore
// preferred. Tests: LatticeResolution in lattice_test.cpp, ModulusBand in modulus_band_test.cpp.

namespace livegs {

// Maximum substeps per frame. A stiffer body is clipped to the stiffness that this number reaches. During a
// hard impact the body takes impact_substeps times as many.
inline constexpr int kMaxBodySubsteps = 32;

struct ResolutionRequest {
  Eigen::Vector3d size_m;      // edges of the bounding box, lattice axes
  double middle_side_m = 0;    // middle side of the material if size_m is larger; 0: from size_m
  double particle_edge_m = 0;  // cells narrower than 1.5 of it would be emptier than the material
  double youngs_modulus_pa = 0, poisson_ratio = 0, density_kg_m3 = 0;
  double rate_hz = 0;
  int substeps = 1;  // per frame, of the scene
  // Cell width, m, raised to half of particle_edge_m if smaller. 0: the width is chosen too.
  double cell_width_m = 0;
  int body_substeps = 0;  // > 0: per frame, rounded up to a multiple of the scene's; 0: chosen
  // Per frame; met first by wider cells, then by fewer substeps.
  double max_node_substeps = kMaxNodeSubsteps;
  double max_courant = 1.0;  // additional bound, below courant_limit
};
// Maximum Courant number for a body with its whole boundary moved. Cells next to held nodes share a stress
// unequally, by the square of the step. At this value the interior follows within 2 %.
inline constexpr double kBoundaryCourant = 0.4;

// Values by material: first the body's own, with a density of mass over volume, then the regions that have a
// material.
struct BodyMaterials {
  std::vector<IsotropicMaterial> elastic;
  std::vector<double> densities_kg_m3, plasticities;
};
BodyMaterials body_materials(const Material& own, std::span<const RegionMaterial> regions, double volume_m3);

// Uses the fastest wave speed of all materials and the largest Poisson's ratio. `boundary_moved`: the whole
// boundary has a prescribed motion.
ResolutionRequest resolution_request(const BodyExtent& extent, const BodyMaterials& materials,
                                     bool boundary_moved, double rate_hz, int substeps);
// Request of a description, including its cell width if given. Preconditions: those of measure_extent.
ResolutionRequest resolution_request(const ElasticBodyDescription& description, double rate_hz, int substeps);

struct LatticeResolution {
  double cell_width_m = 0;
  int substeps = 1;              // per frame; a multiple of the scene's
  double courant = 0;            // sqrt(E/rho) h / a of the simulated modulus
  double youngs_modulus_pa = 0;  // the simulated modulus
  bool clipped = false;          // youngs_modulus_pa is below the requested modulus
  // Cells are too wide for the thickness, or a frame costs too much.
  bool over_budget = false;
  double node_substeps = 0;  // per frame, from the bounding box
  int impact_substeps = 1;   // steps per substep during a hard impact; 1 ... 4
  // Wave speed sqrt(E/rho) of the simulated material.
  double wave_speed_m_s(double rate_hz) const { return courant * rate_hz * substeps * cell_width_m; }
};

// Maximum Courant number of a single layer of cells, and of a body with more than kMaxThinPart of its volume
// in oblique or loose material thinner than half a cell (thin_part). Larger: the light nodes of nearly empty
// cells overshoot when the body lands, and it gains energy.
inline constexpr double kMaxThinCourant = 0.5;

// The largest Courant number, sqrt(E/rho) h / a, at which dynamics and contact are within their stated
// errors. `cells_across` counts cells across the thinnest side. Statics are within them too if the body is at
// least eight cells long.
double courant_limit(double poisson_ratio, double cells_across);

LatticeResolution choose_resolution(const ResolutionRequest& request);

// Predicted stiffness of a lattice, E_app / E, known before the simulation runs. modulus_band.cpp derives the
// bounds from it; modulus_band_test.cpp compares them with measured ratios.
//
// Ybar is the volume mean of Y = 1 / (E V h_e² A0): the compliance of the material relative to the response
// of one sweep. A0 is a third of the trace of G = sum w_i g_i g_iᵀ. Ybar covers both thickness and placement
// of the lattice: 2 / Co² (Co with h_e) inside a wide body, a quarter of it if the body is one cell across.
// Held cells do not count. Infinite if all cells are held.
double mean_pass_compliance(const Lattice& lattice, std::span<const double> inverse_masses_per_kg,
                            double youngs_modulus_pa, double step_s);

// The largest modulus that one compensated sweep per substep reaches: 4.15 rho a² (cells / nodes) / h_e². It
// is reached just above this value; a much larger modulus shows half of it.
double modulus_ceiling_pa(const Lattice& lattice, double density_kg_m3, double step_s);

// Excess of the apparent modulus in tension by the ends, as a fraction of E: 2 Co² / n, with Co = sqrt(E/rho)
// h_e / a and n cells from end to end. Cells beyond a cell undo part of its correction, and the compensation
// adds the same amount to every cell; but no cells follow beyond the ends. Valid for one to eight cells and
// nu from 0 to 0.45. The middle half of four or more cells has no excess. The same holds across, with the
// number of cells there.
double end_excess(double courant, double cells_along);
// Bodies with more end excess are not reported as exact; Poisson's ratio at 0.45 is then off by 0.02.
inline constexpr double kMaxEndExcess = 0.0405;

// Bounds of the bending stiffness, relative to the exact one, of material thinner than half a cell that is
// oblique in the lattice or known by surface points only. A body with more than kMaxThinPart of its volume in
// such cells is not reported as exact.
inline constexpr double kMaxThinPart = 0.05, kThinBendsFrom = 0.2, kThinBendsTo = 6.5;
double thin_part(const Lattice& lattice, bool loose);

struct BandRequest {
  double mean_pass_compliance = 0.0;  // Ybar
  double poisson_ratio = 0.0;
  double cells_across = 4.0, cells_along = 16.0;  // of the thinnest and the longest side
  double courant = 0.0;                           // with h_e
  double ceiling_ratio = 1.0;                     // modulus_ceiling_pa / E
};
struct ModulusBand {
  ElasticBand band;
  double ratio_low, ratio_high;  // E_app / E in tension along the longest side
  double ratio_across = 0.0;     // upper bound in tension or compression across the shortest side; 0: unknown
};
// Exact if Ybar is large and the end excess small; below that a band, as wide as the measured spread; clipped
// near the ceiling; unknown with too few cells along and too long steps to reach equilibrium under loads at
// the ends. A body whose cells are chosen automatically is never in the last two classes: its E is lowered to
// the value that eight cells along reproduce exactly, and the body reports this.
ModulusBand band_of(const BandRequest& request);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>

#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/lattice/lattice.h"

// A cell with a sheet or cord thinner than itself, in any orientation.
//
// A trilinear cell bends along its own axes only: its displacement contains the products yz, xz, xy of the
// coordinates but no squares. Bending of an oblique sheet needs both. Its mean strain, which is stiff, then
// takes part in a soft mode, and the sheet is far too stiff. This element therefore interprets the amplitudes
// of the products as bending and twisting of the material along its own principal axes: nine fields,
// quadratic in the coordinates. The squares of each field are added to the strain at the centroid of the
// material. This is an assumed strain (Simo and Hughes 1986); the fields are those of incompatible modes
// (Wilson 1973), but without additional unknowns.
//
// The stiffness of a field follows from the spread of the material: E t²/12 for bending of a sheet, G t²/3
// for its twisting, the elliptic formula for twisting of a cord.
//
// Validated against beams (tests/server/physics/elastic/plate_cell_test.cpp): a flat strip in rotated
// lattices and a quarter of a cylinder, with cells of several thicknesses.

namespace livegs {

// Measures of a cell: mean strain at the centroid of the material (Mandel), then the amplitudes of modes yz,
// xz, xy, xyz, three components each; all in the cell's rotated frame.
using Vector18 = Eigen::Matrix<double, 18, 1>;
using Matrix18 = Eigen::Matrix<double, 18, 18>;

// Elasticity matrix for mean strain (Mandel, Pa): 2 mu + lambda.
Matrix6 strain_modulus(const IsotropicMaterial& material);

// Stiffness K of the energy zᵀ K z / 2, J. `mean_strain_modulus_pa` is strain_modulus(material), or a modulus
// with the sweep's compliance subtracted. Precondition: cell.thin is set.
Matrix18 thin_cell_stiffness(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material,
                             const Matrix6& mean_strain_modulus_pa);

// B M^-1 Bᵀ, 1/kg: response of all measures to an impulse on one.
Matrix18 thin_cell_mobility(const LatticeCell& cell, double cell_width_m,
                            const std::array<double, 8>& inverse_masses_per_kg);

// Squared bending strain of the sheet's faces over the squared amplitude of the cell's modes, 1/m²: (4 / a)²,
// as for a full cell, times (thickness / width)². A sheet can bend to a radius of about one cell.
double thin_cell_fold(const LatticeCell& cell, double cell_width_m);

// Gain of an exact solve of the cell in one step: impulses -(gain z), kg m, with gain = (K^-1 / h² + B M^-1
// Bᵀ)^-1. Corner i moves by w_i R (sigma g_i + sum_j gamma_ji eta_j / 8), with sigma and eta the strain and
// mode parts of the impulses.
Matrix18 thin_cell_gain(const Matrix18& stiffness, const Matrix18& mobility, double step_s);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>

#include "physics/elastic/resolution/cell_stiffness.h"
#include "physics/lattice/lattice.h"

// A cell that holds a sheet or a cord thinner than itself, lying as it likes.
//
// A trilinear cell bends along its own axes only: its displacement holds the products yz, xz, xy of the
// coordinates but no squares. A sheet across the cell that bends needs both, so that its mean strain, which
// is stiff, takes part in what is soft: at 45 degrees a sheet of a fifth of the cell's width is 40 times too
// stiff. Here the amplitudes of the products are read as bending and twisting of the material along its own
// principal axes, nine fields that are quadratic in the coordinates; each field's squares are put back into
// the strain at the material's centroid (an assumed strain, as Simo and Hughes 1986 use the word; the fields
// are those of incompatible modes, Wilson 1973, but with no unknowns of their own). A field costs what the
// material's spread says: E t²/12 for bending a sheet, G t²/3 for twisting it, the elliptic formula for
// twisting a cord.
//
// Measured against beams (tests/server/physics/elastic/plate_cell_test.cpp): a flat strip in a lattice turned
// any way and a quarter of a cylinder, cells of 2 to 10 thicknesses.

namespace livegs {

// What a cell measures: mean strain at the material's centroid (Mandel), then the amplitudes of the modes yz,
// xz, xy, xyz, three components each, all in the cell's turned frame.
using Vector18 = Eigen::Matrix<double, 18, 1>;
using Matrix18 = Eigen::Matrix<double, 18, 18>;

// Stress of a strain, Pa, Mandel: 2 mu + lambda.
Matrix6 strain_modulus(const IsotropicMaterial& material);

// K of the energy z K z / 2, J. The mean strain may have a modulus of its own, from which the sweep's
// compliance has been subtracted; else it is strain_modulus(material). Precondition: cell.thin.
Matrix18 thin_cell_stiffness(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material,
                             const Matrix6& mean_strain_modulus_pa);

// B M^-1 Bᵀ, 1/kg: what an impulse on one measure moves the others by.
Matrix18 thin_cell_mobility(const LatticeCell& cell, double cell_width_m,
                            const std::array<double, 8>& inverse_masses_per_kg);

// What bending strains the faces of the sheet by, squared, over the squared amplitude of the cell's modes,
// 1/m²: that of a full cell's faces, (4 / a)², times the square of thickness over width. A sheet may well
// bend by a radius of its cells.
double thin_cell_fold(const LatticeCell& cell, double cell_width_m);

// One step solves the cell exactly: impulses -(gain z), kg m, with gain = (K^-1 / h² + B M^-1 Bᵀ)^-1; corner
// i moves by w_i R (sigma g_i + sum_j gamma_ji eta_j / 8), sigma and eta the strain and mode parts of it.
Matrix18 thin_cell_gain(const Matrix18& stiffness, const Matrix18& mobility, double step_s);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>

#include "physics/lattice/lattice.h"

// The constants of one cell's constraint block: its geometry and masses, and what Young's modulus and
// Poisson's ratio mean for one substep (elastic-study.md 2.2 to 2.5).

namespace livegs {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Mandel's notation of a symmetric matrix: 11, 22, 33, then 23, 13, 12 times the square root of two, so that
// the product of two matrices, summed, is the product of their vectors.
Vector6 mandel(const Eigen::Matrix3d& symmetric);
Eigen::Matrix3d from_mandel(const Vector6& vector);

struct IsotropicMaterial {
  double youngs_modulus_pa, poisson_ratio;
  double shear_modulus_pa() const { return youngs_modulus_pa / (2.0 * (1.0 + poisson_ratio)); }
  double lame_lambda_pa() const {
    return youngs_modulus_pa * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  }
};

// What does not depend on the step. g_i is the gradient of corner i's weight at the material's centroid, w_i
// its inverse mass.
struct CellBlock {
  Eigen::Matrix3d mobility;                      // G = sum w_i g_i g_iᵀ
  std::array<Eigen::Vector3d, 4> mode_coupling;  // sum gamma_ji w_i g_i: how the strain update moves mode j
  double largest_inverse_mass;
};

// The products of corner signs that the eight corner displacements hold beyond mean strain: yz, xz, xy, xyz.
inline constexpr int kModeCount = 4;
double mode_sign(int mode, int corner);

CellBlock make_cell_block(const LatticeCell& cell, double cell_width_m,
                          const std::array<double, 8>& inverse_masses);

// Stiffness of component d of mode j against its amplitude, N/m: bending is exact for one cell through the
// thickness by E, twisting by mu; the spread says how much of the cell the material fills.
std::array<std::array<double, 3>, kModeCount> mode_stiffness(const LatticeCell& cell, double cell_width_m,
                                                             const IsotropicMaterial& material);

// What one sweep multiplies by, for a step whose velocity update divides by `step_s` (h, or 2h/3 of BDF2).
struct CellGains {
  Matrix6 shear;             // H = (A + alpha_mu)^-1, Mandel
  double volume_compliance;  // alpha_lambda; a large multiple of G when lambda is zero
  std::array<std::array<double, 3>, kModeCount> mode;  // by mode and component: eta = -gain q
};
CellGains make_cell_gains(const LatticeCell& cell, const CellBlock& block, double cell_width_m,
                          const IsotropicMaterial& material, double step_s, bool compensate = true);

// Stress of a strain, Pa, Mandel, from which the sweep's own compliance has been taken: what make_cell_gains
// uses as one matrix.
Matrix6 compensated_modulus(const LatticeCell& cell, const CellBlock& block,
                            const IsotropicMaterial& material, double step_s);

// Energy of a cell with mean strain S - I, mean volume ratio det F and mode amplitudes q_j in the cell's
// turned frame.
double cell_energy(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material,
                   const Eigen::Matrix3d& strain, double volume_ratio,
                   const std::array<Eigen::Vector3d, kModeCount>& modes);

}  // namespace livegs

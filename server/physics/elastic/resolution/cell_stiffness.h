// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>

#include "physics/lattice/lattice.h"

// Constants of one cell's constraint block: geometry and masses, and the effect of Young's modulus and
// Poisson's ratio in one substep. elastic/cells/kernels/cell_kernels.cpp describes the block.

namespace livegs {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Mandel notation of a symmetric matrix: 11, 22, 33, then sqrt(2) times 23, 13, 12. The scalar product of two
// vectors is then the double contraction of their matrices.
Vector6 mandel(const Eigen::Matrix3d& symmetric);
Eigen::Matrix3d from_mandel(const Vector6& vector);

struct IsotropicMaterial {
  double youngs_modulus_pa, poisson_ratio;
  double shear_modulus_pa() const { return youngs_modulus_pa / (2.0 * (1.0 + poisson_ratio)); }
  double lame_lambda_pa() const {
    return youngs_modulus_pa * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  }
};

// Constants that do not depend on the step. g_i is the gradient of corner i's weight at the centroid of the
// material, w_i its inverse mass.
struct CellBlock {
  Eigen::Matrix3d mobility;  // G = sum w_i g_i g_iᵀ
  // sum gamma_ji w_i g_i: effect of the strain update on mode j.
  std::array<Eigen::Vector3d, 4> mode_coupling;
  double largest_inverse_mass;
};

// Hourglass modes: products of the corner signs that mean strain does not contain, yz, xz, xy, xyz.
inline constexpr int kModeCount = 4;
double mode_sign(int mode, int corner);

CellBlock make_cell_block(const LatticeCell& cell, double cell_width_m,
                          const std::array<double, 8>& inverse_masses);

// Stiffness of component d of mode j with respect to its amplitude, N/m. Bending (by E) and twisting (by mu)
// are exact for one cell through the thickness. The spread accounts for partly filled cells.
std::array<std::array<double, 3>, kModeCount> mode_stiffness(const LatticeCell& cell, double cell_width_m,
                                                             const IsotropicMaterial& material);

// Factors of one sweep, for a step whose velocity update divides by `step_s` (h, or 2h/3 for BDF2).
struct CellGains {
  Matrix6 shear;             // H = (A + alpha_mu)^-1, Mandel
  double volume_compliance;  // alpha_lambda; a large multiple of G if lambda is zero
  std::array<std::array<double, 3>, kModeCount> mode;  // by mode and component: eta = -gain q
};
CellGains make_cell_gains(const LatticeCell& cell, const CellBlock& block, double cell_width_m,
                          const IsotropicMaterial& material, double step_s, bool compensate = true);

// Elasticity matrix (Mandel, Pa), less the compliance that the sweep adds. make_cell_gains uses the same
// compensation.
Matrix6 compensated_modulus(const LatticeCell& cell, const CellBlock& block,
                            const IsotropicMaterial& material, double step_s);

// Energy of a cell with mean strain S - I, mean volume ratio det F and mode amplitudes q_j in the cell's
// rotated frame.
double cell_energy(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material,
                   const Eigen::Matrix3d& strain, double volume_ratio,
                   const std::array<Eigen::Vector3d, kModeCount>& modes);

}  // namespace livegs

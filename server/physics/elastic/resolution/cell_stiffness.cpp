// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/resolution/cell_stiffness.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Minimum compliance left by the compensation, relative to the material's compliance.
constexpr double kMinComplianceRatio = 0.02;

// One Gauss-Seidel sweep from zero multipliers leaves a cell too soft by k A0, because its neighbours undo
// part of its correction. k depends on Y, the compliance of the material relative to that of the nodes.
// Fitted to tension tests; tests/accuracy/tension_test.cpp checks the modulus.
double pass_compliance(double y_ratio) {
  if (y_ratio < 1.1) return std::min(y_ratio, 1.08);
  const double q = y_ratio - 0.48;
  const double b = 2.0 - 2.5 * q, c = 1.2 - 2.0 * q;
  const double y = (-b + std::sqrt(std::max(0.0, b * b - 10.0 * c))) / 5.0;
  return std::min(y_ratio - y, 1.08);
}

// 1 / (2 mu V h²) and 1 / (3 K V h²), less the compliance that the sweep adds.
struct Compliances {
  double shear, bulk;
};
Compliances compliances(const LatticeCell& cell, const CellBlock& block, const IsotropicMaterial& material,
                        double step_s, bool compensate) {
  const double volume_step = cell.volume_m3 * step_s * step_s;
  const double own_mobility = block.mobility.trace() / 3.0;
  const double y_ratio = 1.0 / std::max(material.youngs_modulus_pa * volume_step * own_mobility, 1e-300);
  const double softening = compensate ? own_mobility * pass_compliance(y_ratio) : 0.0;
  const auto compensated = [&](double modulus) {
    const double compliance = 1.0 / (modulus * volume_step);
    return std::max(compliance - softening, kMinComplianceRatio * compliance);
  };
  return {compensated(2.0 * material.shear_modulus_pa()),
          compensated(material.youngs_modulus_pa / (1.0 - 2.0 * material.poisson_ratio))};
}

}  // namespace

std::array<std::array<double, 3>, kModeCount> mode_stiffness(const LatticeCell& cell, double a,
                                                             const IsotropicMaterial& material) {
  const double bending = 4.0 / 3.0 * material.youngs_modulus_pa * cell.volume_m3 / (a * a);
  const double twisting = 1.125 * material.shear_modulus_pa() * cell.volume_m3 / (a * a);
  const Vector3d& r = cell.spread;
  std::array<std::array<double, 3>, kModeCount> stiffness;
  for (int normal = 0; normal < 3; ++normal) {  // mode yz has normal x, and so on
    const int d = (normal + 1) % 3, e = (normal + 2) % 3;
    stiffness[normal][d] = bending * r[e];
    stiffness[normal][e] = bending * r[d];
    stiffness[normal][normal] = twisting * 0.5 * (r[d] + r[e]);
  }
  stiffness[3].fill(twisting * r.x() * r.y() * r.z());
  return stiffness;
}

Vector6 mandel(const Matrix3d& m) {
  Vector6 v;
  v << m(0, 0), m(1, 1), m(2, 2), M_SQRT2 * m(1, 2), M_SQRT2 * m(0, 2), M_SQRT2 * m(0, 1);
  return v;
}

Matrix3d from_mandel(const Vector6& v) {
  Matrix3d m;
  const double yz = v[3] * M_SQRT1_2, xz = v[4] * M_SQRT1_2, xy = v[5] * M_SQRT1_2;
  m << v[0], xy, xz, xy, v[1], yz, xz, yz, v[2];
  return m;
}

double mode_sign(int mode, int corner) {
  const Vector3d sign = corner_sign(corner);
  return mode == 3 ? sign.prod() : sign[(mode + 1) % 3] * sign[(mode + 2) % 3];
}

CellBlock make_cell_block(const LatticeCell& cell, double cell_width_m,
                          const std::array<double, 8>& inverse_masses) {
  const std::array<Vector3d, 8> gradients = trilinear_gradients(cell.centroid, cell_width_m);
  CellBlock block;
  block.mobility.setZero();
  block.mode_coupling.fill(Vector3d::Zero());
  block.largest_inverse_mass = 0.0;
  for (int c = 0; c < 8; ++c) {
    const double w = inverse_masses[c];
    block.mobility += w * gradients[c] * gradients[c].transpose();
    for (int j = 0; j < kModeCount; ++j) block.mode_coupling[j] += mode_sign(j, c) * w * gradients[c];
    block.largest_inverse_mass = std::max(block.largest_inverse_mass, w);
  }
  return block;
}

Matrix6 compensated_modulus(const LatticeCell& cell, const CellBlock& block,
                            const IsotropicMaterial& material, double step_s) {
  const auto [shear, bulk] = compliances(cell, block, material, step_s, true);
  const double volume_step = cell.volume_m3 * step_s * step_s;
  Matrix6 modulus = Matrix6::Identity() / (shear * volume_step);
  modulus.topLeftCorner<3, 3>().array() += (1.0 / bulk - 1.0 / shear) / (3.0 * volume_step);
  return modulus;
}

CellGains make_cell_gains(const LatticeCell& cell, const CellBlock& block, double cell_width_m,
                          const IsotropicMaterial& material, double step_s, bool compensate) {
  const double own_mobility = block.mobility.trace() / 3.0;
  const auto [alpha_mu, alpha_k] = compliances(cell, block, material, step_s, compensate);
  const double lambda_step = (1.0 / alpha_k - 1.0 / alpha_mu) / 3.0;  // lambda V h²

  CellGains gains;
  Matrix6 a;
  for (int k = 0; k < 6; ++k) {
    const Matrix3d product = from_mandel(Vector6::Unit(k)) * block.mobility;
    a.col(k) = mandel(0.5 * (product + product.transpose()));
  }
  gains.shear = (a + alpha_mu * Matrix6::Identity()).inverse();
  // A material without lambda has no volume row.
  gains.volume_compliance =
      material.poisson_ratio > 0.0 && lambda_step > 0.0 ? 1.0 / lambda_step : 1e12 * own_mobility;

  const auto stiffness = mode_stiffness(cell, cell_width_m, material);
  for (int j = 0; j < kModeCount; ++j) {
    for (int d = 0; d < 3; ++d) {
      const double k_step = stiffness[j][d] * step_s * step_s;
      gains.mode[j][d] = k_step / (k_step * block.largest_inverse_mass / 8.0 + 1.0);
    }
  }
  return gains;
}

double cell_energy(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material,
                   const Matrix3d& strain, double volume_ratio,
                   const std::array<Vector3d, kModeCount>& modes) {
  const double change = volume_ratio - 1.0;
  double energy = cell.volume_m3 * (material.shear_modulus_pa() * strain.squaredNorm() +
                                    0.5 * material.lame_lambda_pa() * change * change);
  const auto stiffness = mode_stiffness(cell, cell_width_m, material);
  for (int j = 0; j < kModeCount; ++j) {
    for (int d = 0; d < 3; ++d) energy += 0.5 * stiffness[j][d] * modes[j][d] * modes[j][d];
  }
  return energy;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/cells/plate_cell.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Matrix6x9 = Eigen::Matrix<double, 6, 9>;

// Damping of the least-squares fit of the field amplitudes. Some lattices contain two fields that differ only
// by squares (a sheet at exactly 45 degrees).
constexpr double kDamping = 0.003;
// Stiffness factor of strain that varies across an oblique cell in the plane of the sheet; the full value
// resists bending of a curved sheet too much. Cells along the lattice axes keep the full value; otherwise a
// strip one cell wide would bend sideways too easily.
constexpr double kObliqueInPlane = 0.2;
// A sheet is fully oblique if the largest component of its normal is below one by at least this value.
constexpr double kObliqueBelow = 0.03;
// Stiffness of mode xyz, relative to the bending stiffness of a full cell.
constexpr double kThirdOrder = 0.01;

// Second derivatives of a quadratic field: [i](k, l) is that of component i by coordinates k and l.
using Quadratic = std::array<Matrix3d, 3>;

// Fibres along e bend towards f: u = f s²/2 - e s t, with s and t the coordinates along e and f. The strain
// along e is -t.
Quadratic bending(const Vector3d& e, const Vector3d& f) {
  Quadratic field;
  for (int i = 0; i < 3; ++i)
    field[i] = f[i] * e * e.transpose() - e[i] * (e * f.transpose() + f * e.transpose());
  return field;
}

// u = n s t.
Quadratic warping(const Vector3d& n, const Vector3d& e, const Vector3d& f) {
  Quadratic field;
  for (int i = 0; i < 3; ++i) field[i] = n[i] * (e * f.transpose() + f * e.transpose());
  return field;
}

// The nine fields: the mode amplitudes that each causes, the strain at the centroid that the modes do not
// contain, and the stiffness.
struct Fields {
  Matrix9 shown = Matrix9::Zero();
  Matrix6x9 hidden = Matrix6x9::Zero();
  Matrix9 stiffness = Matrix9::Zero();
};

Fields slider_parameters(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material,
                         double in_plane) {
  const Matrix3d& axes = cell.thin->axes;
  const Vector3d centroid_m = 0.5 * cell_width_m * cell.centroid;
  // Strain may vary less along an axis the fuller the cell is along it.
  Vector3d variance_m2 = cell.thin->variance_m2;
  for (int k = 1; k < 3; ++k) {
    const double fullness = std::min(1.0, 12.0 * variance_m2[k] / (cell_width_m * cell_width_m));
    variance_m2[k] *= 1.0 - (1.0 - in_plane) * fullness * fullness;
  }
  Fields fields;
  int column = 0;
  const auto add = [&](const Quadratic& field) {
    for (int j = 0; j < 3; ++j) {
      const int k = j == 0, l = j == 2 ? 1 : 2;  // axes of modes yz, xz, xy
      for (int i = 0; i < 3; ++i)
        fields.shown(3 * j + i, column) = 0.25 * cell_width_m * cell_width_m * field[i](k, l);
    }
    Matrix3d gradient;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) gradient(i, k) = field[i](k, k) * centroid_m[k];
    }
    fields.hidden.col(column++) = mandel(0.5 * (gradient + gradient.transpose()));
  };
  for (int e = 0; e < 3; ++e) {
    for (int f = 0; f < 3; ++f) {
      if (e == f) continue;
      fields.stiffness(column, column) = material.youngs_modulus_pa * cell.volume_m3 * variance_m2[f];
      add(bending(axes.col(e), axes.col(f)));
    }
  }
  for (int n = 0; n < 3; ++n) add(warping(axes.col(n), axes.col((n + 1) % 3), axes.col((n + 2) % 3)));
  // Shear between e and f varies along n by the sum of the warpings of e and f.
  for (int n = 0; n < 3; ++n) {
    const int e = 6 + (n + 1) % 3, f = 6 + (n + 2) % 3;
    const double shear = material.shear_modulus_pa() * cell.volume_m3 * variance_m2[n];
    for (const int row : {e, f}) {
      for (const int other : {e, f}) fields.stiffness(row, other) += shear;
    }
  }
  return fields;
}

double part_in_plane(const Vector3d& normal) {
  const double oblique = std::min(1.0, (1.0 - normal.cwiseAbs().maxCoeff()) / kObliqueBelow);
  return 1.0 - (1.0 - kObliqueInPlane) * oblique;
}

}  // namespace

Matrix6 strain_modulus(const IsotropicMaterial& material) {
  Matrix6 modulus = 2.0 * material.shear_modulus_pa() * Matrix6::Identity();
  modulus.topLeftCorner<3, 3>().array() += material.lame_lambda_pa();
  return modulus;
}

Matrix18 thin_cell_stiffness(const LatticeCell& cell, double cell_width_m, const IsotropicMaterial& material,
                             const Matrix6& mean_strain_modulus_pa) {
  const double in_plane = part_in_plane(cell.thin->axes.col(0));
  const Fields fields = slider_parameters(cell, cell_width_m, material, in_plane);
  // Where several combinations of fields cause the same amplitudes, the softest is used.
  const double scale = 0.25 * cell_width_m * cell_width_m;
  const Matrix9 softness = fields.stiffness.diagonal().minCoeff() * fields.stiffness.inverse();
  const Matrix9 normal =
      fields.shown * softness * fields.shown.transpose() / (scale * scale) + kDamping * Matrix9::Identity();
  const Matrix9 amplitude_of_mode = softness * fields.shown.transpose() * normal.inverse() / (scale * scale);
  const Matrix9 unexplained = Matrix9::Identity() - fields.shown * amplitude_of_mode;

  Eigen::Matrix<double, 6, 18> strain = Eigen::Matrix<double, 6, 18>::Zero();
  strain.leftCols<6>().setIdentity();
  strain.middleCols<9>(6) = fields.hidden * amplitude_of_mode;
  Matrix18 stiffness = cell.volume_m3 * strain.transpose() * mean_strain_modulus_pa * strain;
  const double full_bending =
      4.0 / 3.0 * material.youngs_modulus_pa * cell.volume_m3 / (cell_width_m * cell_width_m);
  stiffness.block<9, 9>(6, 6) += amplitude_of_mode.transpose() * fields.stiffness * amplitude_of_mode +
                                 in_plane * full_bending * unexplained.transpose() * unexplained;
  stiffness.bottomRightCorner<3, 3>().diagonal().array() += kThirdOrder * full_bending;
  return 0.5 * (stiffness + stiffness.transpose());
}

double thin_cell_fold(const LatticeCell& cell, double cell_width_m) {
  const double width2 = cell_width_m * cell_width_m;
  return 16.0 / width2 * std::min(1.0, 12.0 * cell.thin->variance_m2.minCoeff() / width2);
}

Matrix18 thin_cell_mobility(const LatticeCell& cell, double cell_width_m,
                            const std::array<double, 8>& inverse_masses_per_kg) {
  const auto gradients = trilinear_gradients(cell.centroid, cell_width_m);
  Matrix18 mobility = Matrix18::Zero();
  for (int c = 0; c < 8; ++c) {
    for (int d = 0; d < 3; ++d) {
      Vector18 column;
      Matrix3d gradient = Matrix3d::Zero();
      gradient.row(d) = gradients[c].transpose();
      column.head<6>() = mandel(0.5 * (gradient + gradient.transpose()));
      column.tail<12>().setZero();
      for (int j = 0; j < kModeCount; ++j) column[6 + 3 * j + d] = 0.125 * mode_sign(j, c);
      mobility += inverse_masses_per_kg[c] * column * column.transpose();
    }
  }
  return mobility;
}

Matrix18 thin_cell_gain(const Matrix18& stiffness, const Matrix18& mobility, double step_s) {
  const Matrix18 step = step_s * step_s * stiffness;
  const Matrix18 gain = step * (Matrix18::Identity() + mobility * step).partialPivLu().inverse();
  return 0.5 * (gain + gain.transpose());
}

}  // namespace livegs

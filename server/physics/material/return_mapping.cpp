// SPDX-License-Identifier: GPL-3.0-or-later
// Radial return (Wilkins 1964; Simo and Hughes, Computational Inelasticity, 3.3) on a cell's deviatoric
// strain.
#include "physics/material/return_mapping.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using EigenSolver = Eigen::SelfAdjointEigenSolver<Matrix3d>;

Matrix3d stretch_of(const Matrix3d& f) {
  const EigenSolver solver(f.transpose() * f);
  const Vector3d stretches = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return solver.eigenvectors() * stretches.asDiagonal() * solver.eigenvectors().transpose();
}

Matrix3d deviator(const Matrix3d& m) { return m - m.trace() / 3.0 * Matrix3d::Identity(); }

// Symmetrises the matrix and scales it to determinant 1, which removes rounding.
Matrix3d of_unit_volume(const Matrix3d& m) {
  const Matrix3d symmetric = 0.5 * (m + m.transpose());
  return symmetric / std::cbrt(symmetric.determinant());
}

// The positive definite matrix deviator + beta I of determinant 1. Its mean eigenvalue is beta, which is at
// least 1, the geometric mean. There the determinant is convex and increases with beta, so Newton's method
// decreases monotonically to the only root.
Matrix3d with_unit_volume(const Matrix3d& deviator) {
  const Vector3d values = EigenSolver(deviator, Eigen::EigenvaluesOnly).eigenvalues();
  double beta = 1.0 - values[0];  // values[0] is the smallest, so every factor is >= 1
  for (int i = 0; i < 60; ++i) {
    const Vector3d x = values.array() + beta;
    const double step = (x.prod() - 1.0) / (x[0] * x[1] + x[1] * x[2] + x[2] * x[0]);
    beta -= step;
    if (std::abs(step) < 1e-15 * beta) break;
  }
  return of_unit_volume(deviator + beta * Matrix3d::Identity());
}

// exp(s ln D) with the largest s <= 1 for which |exp(s ln D) - I| <= limit. The distance increases with s.
Matrix3d within_limit(const Matrix3d& plastic_part, double limit) {
  if ((plastic_part - Matrix3d::Identity()).norm() <= limit) return plastic_part;
  const EigenSolver solver(plastic_part);
  const Vector3d logarithms = solver.eigenvalues().array().log();
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double s = 0.5 * (low + high);
    (((s * logarithms).array().exp() - 1.0).matrix().norm() <= limit ? low : high) = s;
  }
  const Vector3d values = (low * logarithms).array().exp();
  return of_unit_volume(solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose());
}

}  // namespace

// Width b of a bar stretched to 1 + y with free sides, from the cells' energy (cell_kernels.cpp):
//   2 mu (b - 1) + lambda (det F - 1) (1 + y) b = 0,  det F = (1 + y) b²,  lambda / 2 mu = nu / (1 - 2 nu).
// Both terms increase with b from (1 + y)^(-1/2), where the second is zero, and are convex. Newton's method
// starts at 1 and decreases monotonically.
YieldSurface yield_surface(double plasticity, double poisson_ratio) {
  const double p = std::clamp(plasticity, 0.0, 1.0), nu = std::clamp(poisson_ratio, 0.0, 0.49);
  const double length = 1.0 + (1.0 - p), ratio = nu / (1.0 - 2.0 * nu);
  double width = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double volume = length * width * width;
    width -= (width - 1.0 + ratio * (volume - 1.0) * length * width) /
             (1.0 + ratio * (3.0 * volume - 1.0) * length);
  }
  return {std::sqrt(2.0 / 3.0) * (length - width), p};
}

PlasticFlow flow_plastically(const YieldSurface& surface, const Matrix3d& elastic_deformation,
                             const Matrix3d& plastic_part) {
  const PlasticFlow none{plastic_part, 0.0, false};
  // Degenerate cells do not flow; shape recovery restores them first.
  if (!(surface.limit > 0.0) || !(elastic_deformation.norm() < 100.0)) return none;
  if (!(elastic_deformation.determinant() > kMinVolumeRatio)) return none;

  const Matrix3d stretch = stretch_of(elastic_deformation * plastic_part);
  const Matrix3d strain = deviator(stretch - plastic_part);
  const double size = strain.norm();
  const double rounding = 1e-13;
  if (!(size > surface.radius * (1.0 + rounding) && size > rounding)) return none;

  const Matrix3d flowed = with_unit_volume(deviator(plastic_part) + (1.0 - surface.radius / size) * strain);
  const Matrix3d limited = within_limit(flowed, surface.limit);
  double left = surface.radius;
  if (limited != flowed) {
    left = deviator(stretch - limited).norm();
    if (!(left < size * (1.0 - 1e-12))) return none;  // at the limit and pushed outwards
  }
  return {limited, size * size - left * left, true};
}

}  // namespace livegs

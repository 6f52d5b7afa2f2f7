// SPDX-License-Identifier: Apache-2.0
#include "core/math/pseudo_inverse.h"

#include <Eigen/Eigenvalues>
#include <limits>

namespace livegs {
namespace {

// Eigenvalue over the largest one below which it is rounding.
constexpr double kNullRatio = 8.0 * std::numeric_limits<double>::epsilon();

}  // namespace

Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  const double least = kNullRatio * solver.eigenvalues()[2];
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (solver.eigenvalues()[k] > least) inverse[k] = 1.0 / solver.eigenvalues()[k];
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace livegs

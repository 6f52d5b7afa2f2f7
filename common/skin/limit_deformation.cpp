// SPDX-License-Identifier: Apache-2.0
// Polar factor: Newton's iteration, Higham 1986, Computing the polar decomposition.
#include "skin/limit_deformation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "skin/skin_kernels.h"

namespace livegs {
namespace {

// Newton doubles the digits each time: a step of 3e-4 leaves an error of 5e-8, below float's.
constexpr float kNewtonStepSquared = 1e-7f;

// From singular values within 0.25..4 the iteration converges in at most six steps.
constexpr int kMaxNewtonSteps = 8;

Eigen::Matrix3f cofactors(const Eigen::Matrix3f& m) {
  Eigen::Matrix3f result;
  result.col(0) = m.col(1).cross(m.col(2));
  result.col(1) = m.col(2).cross(m.col(0));
  result.col(2) = m.col(0).cross(m.col(1));
  return result;
}

// Any unit vector across `axis`, which is unit.
Eigen::Vector3d across(const Eigen::Vector3d& axis) { return axis.unitOrthogonal(); }

LimitedDeformation limit_by_singular_values(const Eigen::Matrix3f& gradient) {
  const Eigen::Matrix3d f = gradient.cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(f.transpose() * f);
  Eigen::Matrix3d v;  // right singular vectors, largest first
  v.col(0) = solver.eigenvectors().col(2);
  v.col(1) = solver.eigenvectors().col(1);
  v.col(2) = v.col(0).cross(v.col(1));

  // Left singular vectors. Where the gradient has lost a dimension the missing direction is the rest state's own,
  // as near as it can be: a body crushed to a plane keeps its third axis along the plane's normal.
  Eigen::Matrix3d u;
  Eigen::Vector3d sigma;
  const Eigen::Vector3d first = f * v.col(0);
  sigma[0] = first.norm();
  const double vanishing = 1e-6;
  u.col(0) = sigma[0] > vanishing ? Eigen::Vector3d(first / sigma[0]) : Eigen::Vector3d(v.col(0));
  Eigen::Vector3d second = f * v.col(1);
  second -= u.col(0) * u.col(0).dot(second);
  sigma[1] = second.norm();
  if (sigma[1] > vanishing) {
    u.col(1) = second / sigma[1];
  } else {
    const Eigen::Vector3d projected = v.col(1) - u.col(0) * u.col(0).dot(v.col(1));
    u.col(1) = projected.norm() > vanishing ? Eigen::Vector3d(projected.normalized()) : across(u.col(0));
  }
  u.col(2) = u.col(0).cross(u.col(1));
  sigma[2] = u.col(2).dot(f * v.col(2));  // negative where the gradient is inverted

  const Eigen::Vector3d limited =
      sigma.cwiseMax(static_cast<double>(kMinKernelStretch)).cwiseMin(static_cast<double>(kMaxKernelStretch));
  LimitedDeformation result;
  result.gradient = (u * limited.asDiagonal() * v.transpose()).cast<float>();
  result.rotation = Eigen::Quaterniond(Eigen::Matrix3d(u * v.transpose())).normalized().cast<float>();
  return result;
}

}  // namespace

LimitedDeformation limit_deformation(const Eigen::Matrix3f& gradient) {
  const float norm_squared = gradient.squaredNorm();
  if (!std::isfinite(norm_squared)) return {Eigen::Matrix3f::Identity(), Eigen::Quaternionf::Identity()};

  // |F|² bounds the largest singular value from above; since s1 s2 <= (s1² + s2²) / 2, s3 >= 2 det F / |F|².
  Eigen::Matrix3f cofactor = cofactors(gradient);
  float determinant = gradient.col(0).dot(cofactor.col(0));
  const bool surely_within = norm_squared <= kMaxKernelStretch * kMaxKernelStretch &&
                             2.0f * determinant >= kMinKernelStretch * norm_squared && determinant > 0.0f;
  if (!surely_within) return limit_by_singular_values(gradient);

  Eigen::Matrix3f rotation = gradient;
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    const Eigen::Matrix3f next = 0.5f * (rotation + cofactor * (1.0f / determinant));
    const float moved_squared = (next - rotation).squaredNorm();
    rotation = next;
    if (moved_squared < kNewtonStepSquared) break;
    cofactor = cofactors(rotation);
    determinant = rotation.col(0).dot(cofactor.col(0));
  }
  return {gradient, Eigen::Quaternionf(rotation).normalized()};
}

}  // namespace livegs

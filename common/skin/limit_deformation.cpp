// SPDX-License-Identifier: Apache-2.0
// Polar factor: Newton's iteration, Higham 1986, Computing the polar decomposition.
#include "skin/limit_deformation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "skin/skin_kernels.h"

namespace livegs {
namespace {

using Lanes = Eigen::Array<float, kDeformationLanes, 1>;

struct LaneVector {
  Lanes x, y, z;
};

LaneVector cross(const LaneVector& a, const LaneVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

Lanes dot(const LaneVector& a, const LaneVector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Newton's iteration takes a singular value s to (s + 1/s) / 2. From the ends of the range, 4 and 0.25:
// 2.1, 1.3, 1.03, 1.0006, 1 + 2e-7, and then float has no more digits.
constexpr int kNewtonSteps = 6;
static_assert(kMaxKernelStretch <= 4.0f && kMinKernelStretch >= 0.25f);

// Any unit vector across `axis`, which is unit.
Eigen::Vector3d across(const Eigen::Vector3d& axis) { return axis.unitOrthogonal(); }

void limit_by_singular_values(Eigen::Matrix3f& gradient, Eigen::Quaternionf& rotation) {
  const Eigen::Matrix3d f = gradient.cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(f.transpose() * f);
  Eigen::Matrix3d v;  // right singular vectors, largest first
  v.col(0) = solver.eigenvectors().col(2);
  v.col(1) = solver.eigenvectors().col(1);
  v.col(2) = v.col(0).cross(v.col(1));

  // Left singular vectors. Where the gradient has lost a dimension the missing direction is the rest state's
  // own, as near as it can be: a body crushed to a plane keeps its third axis along the plane's normal.
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
  gradient = (u * limited.asDiagonal() * v.transpose()).cast<float>();
  rotation = Eigen::Quaterniond(Eigen::Matrix3d(u * v.transpose())).normalized().cast<float>();
}

}  // namespace

void limit_deformations(LimitedDeformations& deformations) {
  // Columns of the gradients, a lane each.
  LaneVector column[3];
  for (int lane = 0; lane < kDeformationLanes; ++lane) {
    const float* entries = deformations.gradients[lane].data();
    for (int c = 0; c < 3; ++c) {
      column[c].x[lane] = entries[3 * c];
      column[c].y[lane] = entries[3 * c + 1];
      column[c].z[lane] = entries[3 * c + 2];
    }
  }
  LaneVector cofactor[3] = {cross(column[1], column[2]), cross(column[2], column[0]),
                            cross(column[0], column[1])};
  Lanes determinant = dot(column[0], cofactor[0]);

  // |F|² bounds the largest singular value from above; since s1 s2 <= (s1² + s2²) / 2, s3 >= 2 det F / |F|².
  // NaN and infinity fail the comparisons.
  const Lanes norm_squared =
      dot(column[0], column[0]) + dot(column[1], column[1]) + dot(column[2], column[2]);
  const Eigen::Array<bool, kDeformationLanes, 1> within =
      norm_squared <= kMaxKernelStretch * kMaxKernelStretch &&
      2.0f * determinant >= kMinKernelStretch * norm_squared && determinant > 0.0f;

  for (int step = 0; step < kNewtonSteps; ++step) {
    const Lanes inverse = 0.5f / determinant;
    for (int c = 0; c < 3; ++c) {
      column[c] = {0.5f * column[c].x + cofactor[c].x * inverse, 0.5f * column[c].y + cofactor[c].y * inverse,
                   0.5f * column[c].z + cofactor[c].z * inverse};
    }
    if (step + 1 == kNewtonSteps) break;
    cofactor[0] = cross(column[1], column[2]);
    cofactor[1] = cross(column[2], column[0]);
    cofactor[2] = cross(column[0], column[1]);
    determinant = dot(column[0], cofactor[0]);
  }

  for (int lane = 0; lane < kDeformationLanes; ++lane) {
    if (within[lane]) {
      Eigen::Matrix3f rotation;
      for (int c = 0; c < 3; ++c) rotation.col(c) << column[c].x[lane], column[c].y[lane], column[c].z[lane];
      deformations.rotations[lane] = Eigen::Quaternionf(rotation).normalized();
    } else if (std::isfinite(norm_squared[lane])) {
      limit_by_singular_values(deformations.gradients[lane], deformations.rotations[lane]);
    } else {
      deformations.gradients[lane].setIdentity();
      deformations.rotations[lane].setIdentity();
    }
  }
}

}  // namespace livegs

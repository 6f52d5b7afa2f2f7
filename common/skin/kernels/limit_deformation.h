// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace livegs {

// Gradients per call: one per float of an AVX register. A single polar factor would be limited by division
// latency.
inline constexpr int kDeformationLanes = 8;

// Deformation gradients limited for drawing, and their rotations.
struct LimitedDeformations {
  std::array<Eigen::Matrix3f, kDeformationLanes> gradients;
  std::array<Eigen::Quaternionf, kDeformationLanes> rotations;  // unit; polar factor R of gradient = R S
};

// Clamps the singular values of each gradient to kMinKernelStretch..kMaxKernelStretch, in place, and finds
// its rotation (S is symmetric positive definite). The smallest singular value carries the sign of the
// determinant (Irving et al. 2004, Invertible finite elements), so an inverted cell gives the same result as
// a flat one. A gradient that is not finite gives the identity. Lanes are independent.
void limit_deformations(LimitedDeformations& deformations);
// The gradient only, with the same bits: without the work for its rotation, unless a stretch is out of range.
void limit_gradient(Eigen::Matrix3f& gradient);

}  // namespace livegs

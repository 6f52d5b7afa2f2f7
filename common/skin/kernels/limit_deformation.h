// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace livegs {

// As many gradients are taken at once as an AVX register has floats: one at a time, the polar factor alone
// waits 80 ns on its own divisions.
inline constexpr int kDeformationLanes = 8;

// Deformation gradients fit to draw with, and their rotations.
struct LimitedDeformations {
  std::array<Eigen::Matrix3f, kDeformationLanes> gradients;
  std::array<Eigen::Quaternionf, kDeformationLanes> rotations;  // unit; polar factor R of gradient = R S
};

// Clamps the singular values of each gradient to kMinKernelStretch..kMaxKernelStretch, in place, and finds
// its rotation (S is symmetric positive definite). The smallest singular value carries the sign of the
// determinant (Irving et al. 2004, Invertible finite elements), so an inverted cell gives what a flat one
// gives. A gradient that is not finite gives the identity. Lanes do not influence one another.
void limit_deformations(LimitedDeformations& deformations);

}  // namespace livegs

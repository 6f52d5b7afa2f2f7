// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace livegs {

// A deformation gradient fit to draw with, and its rotation.
struct LimitedDeformation {
  Eigen::Matrix3f gradient;
  Eigen::Quaternionf rotation;  // unit; polar factor R of gradient = R S, S symmetric positive definite
};

// `gradient` with its singular values clamped to kMinKernelStretch..kMaxKernelStretch. The smallest one carries the
// sign of the determinant (Irving et al. 2004, Invertible finite elements), so an inverted cell gives what a flat
// one gives. A gradient that is not finite gives the identity.
LimitedDeformation limit_deformation(const Eigen::Matrix3f& gradient);

}  // namespace livegs

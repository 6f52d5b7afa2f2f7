// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace livegs {

// The Moore-Penrose inverse of a symmetric positive semidefinite matrix. Eigenvalues below rounding (8
// epsilon of the largest) count as 0, for instance the one across the points of a plane.
Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& symmetric);

}  // namespace livegs

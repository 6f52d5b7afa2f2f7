// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace livegs {

// The proper rotation R that is nearest to `matrix` in the Frobenius norm, also of a mirrored or flat one. If
// `matrix` is the sum of to * from^T over pairs of points relative to their means, R is the best rotation
// from `from` to `to` (Kabsch 1976; Umeyama 1991).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

}  // namespace livegs

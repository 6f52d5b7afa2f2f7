// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// A block of 0.2 m whose outer particles are moved to `matrix` times their position; the interior deformation
// gradient must become the matrix. "interior": largest |F - matrix| / |matrix| (Frobenius) over particles at
// least one cell from the surface; bar 2 % at Courant numbers up to 0.4.
Result<Outcome> affine_ramp(const Setup& setup, const Eigen::Matrix3d& matrix);

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace livegs {

// Plasticity of one cluster as published in LIVE-GS (its D_p and p). If |S - I| > 1 - p (Frobenius),
//   D_p <- (I + p (S - I)) D_p,  then, if |D_p - I| > p,  D_p <- I + p (D_p - I) / |D_p - I|.
// S is the stretch of the cluster without its plastic part. Volume and symmetry are not preserved, and the
// result depends on the number of substeps (unlike return_mapping.h). One safeguard is added because the
// inverse of D_p is needed: a D_p with a determinant below 0.001 is rejected. Returns true if D_p changed.
bool creep_plastically(const Eigen::Matrix3d& stretch, double plasticity, Eigen::Matrix3d& plastic_part);

}  // namespace livegs

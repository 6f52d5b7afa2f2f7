// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace livegs {

// LIVE-GS's plasticity of one cluster, to the letter (its D_p and p): when |S - I| > 1 - p (Frobenius),
//   D_p <- (I + p (S - I)) D_p,  then where |D_p - I| > p:  D_p <- I + p (D_p - I) / |D_p - I|.
// S is the cluster's stretch without its plastic part. Nothing keeps its volume or its symmetry, and it flows
// a step at a time: the set depends on the substeps (plastic_flow.h does not). One thing is added, since a
// cluster goes through the inverse of D_p: a D_p of determinant under 0.001 is not taken. True when D_p
// changed.
bool creep_plastically(const Eigen::Matrix3d& stretch, double plasticity, Eigen::Matrix3d& plastic_part);

}  // namespace livegs

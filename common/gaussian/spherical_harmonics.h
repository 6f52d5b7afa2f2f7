// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace livegs {

inline constexpr int kMaxShDegree = 3;
inline constexpr float kShDc = 0.28209479f;  // Y_00 = 1 / (2 sqrt(pi))

// Evaluates the real spherical harmonics of bands 1..degree in a unit direction, with the Condon-Shortley
// sign, in the order of GaussianAsset::sh_rest: l = 1 m = -1, 0, 1; l = 2 m = -2 … . Writes (degree + 1)² - 1
// values. 0 <= degree <= kMaxShDegree.
void evaluate_sh_bands(const Eigen::Vector3f& direction, int degree, float* bands);

// max(0, 0.5 + all bands) per channel; the clamp is applied to the whole sum. `rest` has at least (degree +
// 1)² - 1 coefficients. Never NaN: NaN becomes 0.
Eigen::Vector3f evaluate_sh_colour(const Eigen::Vector3f& dc, const Eigen::Vector3f* rest, int degree,
                                   const Eigen::Vector3f& direction);

}  // namespace livegs

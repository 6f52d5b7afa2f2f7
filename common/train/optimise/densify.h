// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "train/optimise/adam.h"

// Densification: kernels are split where the photos are not met. Where to split follows the error (Rota Bulo
// et al. 2024, Revising Densification in Gaussian Splatting); the number of kernels, the moves of dead
// kernels and the noise are those of Kheradmand et al. 2024, 3D Gaussian Splatting as Markov Chain Monte
// Carlo.

namespace livegs {

inline constexpr double kDeadOpacity = 0.005;  // kernels up to this opacity are moved
inline constexpr double kGrowth = 0.05;        // share of new kernels at each growth
// Distance of the halves of a split kernel from its centre, in standard deviations along its longest axis.
// The halves have sqrt(1 - offset^2) = 0.6 of that axis, so that the pair has the mean and the covariance of
// the kernel. Smaller: halves separate slowly. Larger: gaps between them. The halves keep the opacity of the
// kernel: a larger one would make it more opaque with each split, also if it hides what the photos show.
inline constexpr double kSplitOffset = 0.8;

// `errors`: by kernel, the sum over pixels of its weight times the error of the pixel. Kernels are drawn with
// these weights, each at most once; the halves of a split kernel have half of its error.

// Moves dead kernels, and those that are not finite, onto others, which are split. Returns their number.
size_t relocate_dead(uint64_t seed, uint64_t step, std::vector<float>& errors, KernelParameters& parameters,
                     AdamState& adam);

// Splits kGrowth of the kernels, up to `cap` in all. Returns the number of new kernels.
size_t grow(uint64_t seed, uint64_t step, size_t cap, std::vector<float>& errors,
            KernelParameters& parameters, AdamState& adam);

// Moves transparent kernels at random within their own covariance (equation 8). `rate`: learning rate of
// positions, scene units.
void add_noise(uint64_t seed, uint64_t step, double rate, KernelParameters& parameters);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "train/optimise/adam.h"

// Densification as sampling: Kheradmand et al. 2024, 3D Gaussian Splatting as Markov Chain Monte Carlo.

namespace livegs {

inline constexpr double kDeadOpacity = 0.005;  // kernels up to this opacity are moved
inline constexpr int kMaxCopies = 51;          // of one kernel at once
inline constexpr double kGrowth = 0.05;        // share of new kernels at each growth

// Opacity and factor of the axes with which `copies` kernels in one place look like the one that they replace
// (equation 9). opacity in (0, 1), copies in 1..kMaxCopies.
struct CopiedKernel {
  double opacity, scale_factor;
};
CopiedKernel copied_kernel(double opacity, int copies);

// Moves dead kernels, and those that are not finite, onto others that are drawn by opacity. Returns their
// number.
size_t relocate_dead(uint64_t seed, uint64_t step, KernelParameters& parameters, AdamState& adam);

// Adds kGrowth of the kernels, up to `cap`, as copies of kernels drawn by opacity. Returns their number.
size_t grow(uint64_t seed, uint64_t step, size_t cap, KernelParameters& parameters, AdamState& adam);

// Moves transparent kernels at random within their own covariance (equation 8). `rate`: learning rate of
// positions, scene units.
void add_noise(uint64_t seed, uint64_t step, double rate, KernelParameters& parameters);

}  // namespace livegs

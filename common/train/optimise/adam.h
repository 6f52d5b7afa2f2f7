// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "train/kernel_parameters.h"

namespace livegs {

// Adam (Kingma and Ba 2015, algorithm 1). Its epsilon is 1e-15 instead of 1e-8: gradients of a mean over
// pixels are as small as 1e-9, and the default would stop them.
struct AdamState {
  KernelParameters first, second;  // moments
  uint64_t steps = 0;

  void resize(size_t count) {
    first.resize(count);
    second.resize(count);
  }
  void clear_row(size_t kernel);
};
inline constexpr double kAdamBeta1 = 0.9, kAdamBeta2 = 0.999, kAdamEpsilon = 1e-15;

using Rates = std::array<double, kFamilies>;  // learning rate of each family

// One step. Harmonics of kernels that are not `visible` keep their moments, which saves half of the time.
void adam_step(const KernelParameters& gradient, const Rates& rates, std::span<const uint8_t> visible,
               AdamState& state, KernelParameters& parameters);

}  // namespace livegs

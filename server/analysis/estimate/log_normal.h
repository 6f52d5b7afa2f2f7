// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

namespace livegs {

// Log-normal estimate of a positive number. `sd` is the standard deviation of the logarithm: 0.1 is about 10
// %.
struct LogNormal {
  double mean_ln = 0;
  double sd = 0;
};

// Fuses several estimates of the same number, weighted by precision. Their errors share causes (the same
// size, the same assumed class), so n estimates count as fewer than n: `correlation` 0 … 1 between each pair.
// Contradicting estimates widen the result (Birge 1932).
// Precondition: not empty, every sd positive.
LogNormal fuse(std::span<const LogNormal> looks, double correlation);

// One component of a mixture.
struct WeightedLogNormal {
  double weight = 0;
  LogNormal value;
};

// Mean of the logarithm of a mixture, and the quantile at `share`.
// Precondition: weights are not negative, their sum is positive.
double mixture_mean_ln(std::span<const WeightedLogNormal> mixture);
double mixture_quantile_ln(std::span<const WeightedLogNormal> mixture, double share);

}  // namespace livegs

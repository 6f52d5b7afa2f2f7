// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

namespace livegs {

// What is known of a positive number: its logarithm is normal. `sd` is that of the logarithm: 0.1 is about 10
// %.
struct LogNormal {
  double mean_ln = 0;
  double sd = 0;
};

// Several looks at the same number, weighted by their precisions. Their errors have causes in common (the
// same size, the same idea of what the thing is), so that n looks are worth less than n: `correlation` 0 … 1
// between each two. Looks that contradict each other widen the result (Birge 1932). Precondition: not empty,
// every sd positive.
LogNormal fuse(std::span<const LogNormal> looks, double correlation);

// One of several things that may be the case.
struct WeightedLogNormal {
  double weight = 0;
  LogNormal value;
};

// Of a mixture: the mean of the logarithm, and the value below which `share` of the probability lies.
// Precondition: weights not negative, their sum positive.
double mixture_mean_ln(std::span<const WeightedLogNormal> mixture);
double mixture_quantile_ln(std::span<const WeightedLogNormal> mixture, double share);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>

namespace livegs {

// Log-normal estimate of a positive number. `sd` is the standard deviation of the logarithm: 0.1 is about 10
// %.
struct LogNormal {
  double mean_ln = 0;
  double sd = 0;
};

// One component of a mixture.
struct WeightedLogNormal {
  double weight = 0;
  LogNormal value;
};

// Probability that a measurement is of an unusual or another object, and the standard deviation of the
// logarithm of its error then. A judgement. Larger: outliers have less weight.
inline constexpr double kBroadShare = 0.02, kBroadSd = 1.5;
// Correlation of the errors of two estimates of one mass: both use the same measured size and the same notion
// of a usual object. A judgement. Larger: the less certain of the two has less weight, and ranges are wider.
inline constexpr double kErrorCorrelation = 0.3;

// Fuses two estimates of the same number whose errors have this correlation, 0 to below 1: generalised least
// squares (Aitken 1936). If the less certain one adds nothing, its weight is 0; it is never negative. Each
// estimate is wrong with a small probability, such as that of an unusual object. Its weight is then small.
// The three components are: both right, the first wrong, the second wrong. Their weights are probability
// densities of the distance between the estimates, so those of several pairs compare (Bayes). Precondition:
// every sd positive.
std::array<WeightedLogNormal, 3> fused_mixture(const LogNormal& first, const LogNormal& second,
                                               double correlation);
// The same as one estimate. Estimates that agree narrow it; contradicting ones widen it.
LogNormal fuse(const LogNormal& first, const LogNormal& second, double correlation);

// Density of a mixture over the logarithm, the mean of it, its standard deviation, and the quantile at
// `share`. Precondition: weights are not negative, their sum is positive.
double mixture_density_ln(std::span<const WeightedLogNormal> mixture, double value_ln);
double mixture_mean_ln(std::span<const WeightedLogNormal> mixture);
LogNormal mixture_moments(std::span<const WeightedLogNormal> mixture);
double mixture_quantile_ln(std::span<const WeightedLogNormal> mixture, double share);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/estimate/log_normal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace livegs {

namespace {

// Both right. The weight is the density of their distance.
WeightedLogNormal least_squares(const LogNormal& first, const LogNormal& second, double correlation) {
  const double own = first.sd * first.sd, other = second.sd * second.sd,
               shared = correlation * first.sd * second.sd, spread = own + other - 2 * shared;
  const double distance = second.mean_ln - first.mean_ln;
  // Weight of the second: minimum variance, between 0 and 1.
  const double weight = std::clamp((own - shared) / spread, 0.0, 1.0);
  const double variance =
      (1 - weight) * (1 - weight) * own + weight * weight * other + 2 * weight * (1 - weight) * shared;
  return {std::exp(-0.5 * distance * distance / spread) / std::sqrt(spread),
          {first.mean_ln + weight * distance, std::sqrt(variance)}};
}

LogNormal wrong(const LogNormal& look) { return {look.mean_ln, std::hypot(look.sd, kBroadSd)}; }

}  // namespace

std::array<WeightedLogNormal, 3> fused_mixture(const LogNormal& first, const LogNormal& second,
                                               double correlation) {
  std::array<WeightedLogNormal, 3> mixture = {least_squares(first, second, correlation),
                                              least_squares(wrong(first), second, 0),
                                              least_squares(first, wrong(second), 0)};
  mixture[0].weight *= 1 - 2 * kBroadShare;
  mixture[1].weight *= kBroadShare;
  mixture[2].weight *= kBroadShare;
  return mixture;
}

LogNormal fuse(const LogNormal& first, const LogNormal& second, double correlation) {
  return mixture_moments(fused_mixture(first, second, correlation));
}

double mixture_density_ln(std::span<const WeightedLogNormal> mixture, double value_ln) {
  double weight = 0, sum = 0;
  for (const WeightedLogNormal& part : mixture) {
    const double off = (value_ln - part.value.mean_ln) / part.value.sd;
    weight += part.weight;
    sum += part.weight * std::exp(-0.5 * off * off) / (part.value.sd * std::sqrt(2 * std::numbers::pi));
  }
  return sum / weight;
}

double mixture_mean_ln(std::span<const WeightedLogNormal> mixture) {
  double weight = 0, sum = 0;
  for (const WeightedLogNormal& part : mixture) {
    weight += part.weight;
    sum += part.weight * part.value.mean_ln;
  }
  return sum / weight;
}

LogNormal mixture_moments(std::span<const WeightedLogNormal> mixture) {
  LogNormal moments{mixture_mean_ln(mixture), 0};
  double weight = 0, sum = 0;
  for (const WeightedLogNormal& part : mixture) {
    const double off = part.value.mean_ln - moments.mean_ln;
    weight += part.weight;
    sum += part.weight * (part.value.sd * part.value.sd + off * off);
  }
  moments.sd = std::sqrt(sum / weight);
  return moments;
}

double mixture_quantile_ln(std::span<const WeightedLogNormal> mixture, double share) {
  double weight = 0, low = INFINITY, high = -INFINITY;
  for (const WeightedLogNormal& part : mixture) {
    if (!(part.weight > 0)) continue;
    weight += part.weight;
    low = std::min(low, part.value.mean_ln - 9 * part.value.sd);
    high = std::max(high, part.value.mean_ln + 9 * part.value.sd);
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    double below = 0;
    for (const WeightedLogNormal& part : mixture) {
      if (!(part.weight > 0)) continue;
      below +=
          part.weight * 0.5 * std::erfc((part.value.mean_ln - middle) / (part.value.sd * std::sqrt(2.0)));
    }
    (below < share * weight ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace livegs

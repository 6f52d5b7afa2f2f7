// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/estimate/log_normal.h"

#include <algorithm>
#include <cmath>

namespace livegs {

LogNormal fuse(std::span<const LogNormal> looks, double correlation) {
  double precision = 0, sum = 0;
  for (const LogNormal& look : looks) {
    const double weight = 1 / (look.sd * look.sd);
    precision += weight;
    sum += weight * look.mean_ln;
  }
  LogNormal result;
  result.mean_ln = sum / precision;
  const double others = static_cast<double>(looks.size()) - 1;
  double variance = (1 + correlation * others) / precision;
  if (others > 0) {
    double misfit = 0;
    for (const LogNormal& look : looks) {
      const double z = (look.mean_ln - result.mean_ln) / look.sd;
      misfit += z * z;
    }
    variance *= std::max(1.0, misfit / others);
  }
  result.sd = std::sqrt(variance);
  return result;
}

double mixture_mean_ln(std::span<const WeightedLogNormal> mixture) {
  double weight = 0, sum = 0;
  for (const WeightedLogNormal& part : mixture) {
    weight += part.weight;
    sum += part.weight * part.value.mean_ln;
  }
  return sum / weight;
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

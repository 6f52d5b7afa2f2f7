// SPDX-License-Identifier: GPL-3.0-or-later
// LIVE-GS (Mao et al.): the table that maps the stiffness s E to a deformation resistance.
#include "physics/material.h"

#include <algorithm>
#include <array>

namespace livegs {
namespace {

struct BreakPoint {
  double stiffness_pa;
  double resistance;
};
constexpr std::array<BreakPoint, 5> kTable{{{0.0, 0.0}, {1e5, 0.1}, {1e6, 0.5}, {5e7, 0.8}, {2e8, 1.0}}};

// `to` at `from` = x in the table, clamped to it. Exact at both ends of a part, so that break points survive
// a round trip.
double interpolate(double BreakPoint::*from, double BreakPoint::*to, double x) {
  x = std::clamp(x, 0.0, kTable.back().*from);
  size_t upper = 1;
  while (upper + 1 < kTable.size() && x > kTable[upper].*from) ++upper;
  const BreakPoint &a = kTable[upper - 1], &b = kTable[upper];
  const double t = (x - a.*from) / (b.*from - a.*from);
  return t >= 1.0 ? b.*to : a.*to + t * (b.*to - a.*to);
}

}  // namespace

double deformation_resistance(double effective_youngs_modulus_pa) {
  return interpolate(&BreakPoint::stiffness_pa, &BreakPoint::resistance, effective_youngs_modulus_pa);
}

double effective_youngs_modulus_pa(double deformation_resistance) {
  return interpolate(&BreakPoint::resistance, &BreakPoint::stiffness_pa, deformation_resistance);
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
// LIVE-GS (Mao et al.): the table that maps the stiffness s E to a deformation resistance. The resistance is
// a blend factor, not a stiffness; resistance_stiffness_per_s2() converts it at the paper's substep.
#include "physics/material.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

double resistance_stiffness_per_s2(double deformation_resistance) {
  const double resistance = std::clamp(deformation_resistance, 0.0, 1.0);
  if (resistance == 1.0) return std::numeric_limits<double>::infinity();
  return resistance / ((1.0 - resistance) * kPaperSubstep_s * kPaperSubstep_s);
}

double resistance_blend(double stiffness_per_s2, double substep_s) {
  if (std::isinf(stiffness_per_s2)) return 1.0;
  const double odds = stiffness_per_s2 * substep_s * substep_s;
  return odds / (1.0 + odds);
}

}  // namespace livegs

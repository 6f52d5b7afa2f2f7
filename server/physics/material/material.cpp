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

// Linear interpolation that is exact at both ends, so that break points survive a round trip.
double between(double x, double x0, double x1, double y0, double y1) {
  const double t = (x - x0) / (x1 - x0);
  return t >= 1.0 ? y1 : y0 + t * (y1 - y0);
}

}  // namespace

double deformation_resistance(double effective_youngs_modulus_pa) {
  const double stiffness = std::clamp(effective_youngs_modulus_pa, 0.0, kTable.back().stiffness_pa);
  size_t upper = 1;
  while (upper + 1 < kTable.size() && stiffness > kTable[upper].stiffness_pa) ++upper;
  const BreakPoint &a = kTable[upper - 1], &b = kTable[upper];
  return between(stiffness, a.stiffness_pa, b.stiffness_pa, a.resistance, b.resistance);
}

double effective_youngs_modulus_pa(double deformation_resistance) {
  const double resistance = std::clamp(deformation_resistance, 0.0, 1.0);
  size_t upper = 1;
  while (upper + 1 < kTable.size() && resistance > kTable[upper].resistance) ++upper;
  const BreakPoint &a = kTable[upper - 1], &b = kTable[upper];
  return between(resistance, a.resistance, b.resistance, a.stiffness_pa, b.stiffness_pa);
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

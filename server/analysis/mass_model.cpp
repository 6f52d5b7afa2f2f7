// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/mass_model.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

constexpr double kLightest_kg = 1e-5, kHeaviest_kg = 2000.0;

}  // namespace

MassEstimate estimate_mass(const Span3& density_kg_m3, v1::Physics::Fill fill, const Span3& wall_m,
                           const ObjectFacts& facts) {
  const double volume = facts.mesh.volume_m3, area = facts.mesh.area_m2;
  const bool walled = (fill == v1::Physics::SHELL || fill == v1::Physics::OPEN_SHELL) && wall_m.best > 0;
  MassEstimate estimate;
  char reason[200];
  if (walled) {
    // An open shell that was captured inside and out encloses little: its area counts each wall twice.
    const bool both_walls = fill == v1::Physics::OPEN_SHELL && facts.mesh.mean_wall_m < 3 * wall_m.high;
    const double wall_area = both_walls ? 0.5 * area : area;
    const auto mass = [&](double density, double wall) {
      return std::min(density * wall * wall_area, density * std::max(volume, wall * wall_area));
    };
    estimate.mass_kg = {mass(density_kg_m3.low, wall_m.low), mass(density_kg_m3.best, wall_m.best),
                        mass(density_kg_m3.high, wall_m.high)};
    std::snprintf(reason, sizeof reason, "%.4g kg/m3 x %.3g mm x %.4g m2 of wall", density_kg_m3.best,
                  wall_m.best * 1e3, wall_area);
  } else {
    estimate.mass_kg = {density_kg_m3.low * volume, density_kg_m3.best * volume, density_kg_m3.high * volume};
    std::snprintf(reason, sizeof reason, "%.4g kg/m3 x %.4g m3 enclosed", density_kg_m3.best, volume);
  }
  // A captured surface's volume or area is good to about a quarter; a guessed scale to a factor two in mass.
  const double spread = facts.scale_known ? 1.25 : 2.0;
  estimate.mass_kg.low = std::clamp(estimate.mass_kg.low / spread, kLightest_kg, kHeaviest_kg);
  estimate.mass_kg.best = std::clamp(estimate.mass_kg.best, kLightest_kg, kHeaviest_kg);
  estimate.mass_kg.high = std::clamp(estimate.mass_kg.high * spread, kLightest_kg, kHeaviest_kg);
  estimate.reason = reason;
  if (!facts.scale_known) estimate.reason += "; the scale is a guess";
  return estimate;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/estimate/mass_model.h"

#include <algorithm>
#include <cmath>

#include "analysis/knowledge/value_ranges.h"
#include "analysis/text/message_templates.h"
#include "core/text/format_text.h"

namespace livegs {

MassEstimate estimate_mass(const Span3& density_kg_m3, v1::Physics::Fill fill, const Span3& wall_m,
                           const ObjectFacts& facts) {
  const double volume = facts.mesh.volume_m3, area = facts.mesh.area_m2;
  const bool walled = (fill == v1::Physics::SHELL || fill == v1::Physics::OPEN_SHELL) && wall_m.best > 0;
  MassEstimate estimate;
  if (walled) {
    // An open shell captured inside and outside encloses little, and its area counts each wall twice.
    const bool both_walls = fill == v1::Physics::OPEN_SHELL && facts.mesh.mean_wall_m < 3 * wall_m.high;
    const double wall_area = both_walls ? 0.5 * area : area;
    const auto mass = [&](double density, double wall) {
      return std::min(density * wall * wall_area, density * std::max(volume, wall * wall_area));
    };
    estimate.mass_kg = {mass(density_kg_m3.low, wall_m.low), mass(density_kg_m3.best, wall_m.best),
                        mass(density_kg_m3.high, wall_m.high)};
    estimate.reason = wall_factors(density_kg_m3.best, wall_m.best, wall_area);
  } else {
    estimate.mass_kg = {density_kg_m3.low * volume, density_kg_m3.best * volume, density_kg_m3.high * volume};
    estimate.reason = volume_factors(density_kg_m3.best, volume);
  }
  // The volume or area of a captured surface is uncertain by about a quarter; a guessed scale adds a factor
  // of two in mass.
  const double spread = facts.scale_known ? 1.25 : 2.0;
  estimate.mass_kg.low = std::clamp(estimate.mass_kg.low / spread, kMassRange_kg.low, kMassRange_kg.high);
  estimate.mass_kg.best = std::clamp(estimate.mass_kg.best, kMassRange_kg.low, kMassRange_kg.high);
  estimate.mass_kg.high = std::clamp(estimate.mass_kg.high * spread, kMassRange_kg.low, kMassRange_kg.high);
  if (!facts.scale_known) estimate.reason += MessageTemplates::reasons().say("reason_guessed_scale");
  return estimate;
}

std::string wall_factors(double density_kg_m3, double wall_m, double area_m2) {
  return MessageTemplates::reasons().say("reason_wall", {{"density", format_text("%.4g", density_kg_m3)},
                                                         {"wall", format_text("%.3g", wall_m * 1e3)},
                                                         {"area", format_text("%.4g", area_m2)}});
}

std::string volume_factors(double density_kg_m3, double volume_m3) {
  return MessageTemplates::reasons().say("reason_enclosed", {{"density", format_text("%.4g", density_kg_m3)},
                                                             {"volume", format_text("%.4g", volume_m3)}});
}

}  // namespace livegs

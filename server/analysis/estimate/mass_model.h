// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "analysis/estimate.h"
#include "analysis/knowledge/tables.h"

namespace livegs {

struct MassEstimate {
  Span3 mass_kg;
  std::string reason;
};

// Mass from the fill type: rho V (solid, filled), rho t A (shell), rho t A / 2 (open shell whose mesh has an
// inner and an outer wall). Ranges multiply; a guessed scale widens them.
MassEstimate estimate_mass(const Span3& density_kg_m3, v1::Physics::Fill fill, const Span3& wall_m,
                           const ObjectFacts& facts);

// Formats the factors of a mass: "2200 kg/m3 x 4.5 mm x 0.0275 m2 of wall" or "720 kg/m3 x 0.001 m3
// enclosed". Texts of mass_reasons.json.
std::string wall_factors(double density_kg_m3, double wall_m, double area_m2);
std::string volume_factors(double density_kg_m3, double volume_m3);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "analysis/estimate.h"
#include "analysis/knowledge.h"

namespace livegs {

struct MassEstimate {
  Span3 mass_kg;
  std::string reason;
};

// Mass from how the enclosed volume is filled: rho V (solid, filled), rho t A (shell), rho t A / 2 (an open
// shell whose mesh has an inner and an outer wall). Ranges multiply; a guessed scale widens them.
MassEstimate estimate_mass(const Span3& density_kg_m3, v1::Physics::Fill fill, const Span3& wall_m,
                           const ObjectFacts& facts);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "analysis/estimate.h"
#include "analysis/gate/answer.h"

// Mass bounds from an object's volume and the materials of an answer, independent of its name. Pure; any
// thread.

namespace livegs {

// Minimum mass of an object of this size and material, in kilograms, for a metric scale: the air in its box.
// For materials that are blown, rolled, spun or woven thin: the thinnest film on every visible face, or
// nothing if the surface is drawn too thick. 0 if unknown.
double min_mass_kg(const Answer& answer, const ObjectFacts& facts);

// Checks the volume of the answer's materials against the object: too large for the room, or too small for
// the stated fill. Returns the reason as one line for a user, or "" if consistent.
std::string mass_at_odds(const Answer& answer, const ObjectFacts& facts);

// Names the materials of the largest parts.
std::string materials_of(const Answer& answer);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "analysis/estimate.h"
#include "analysis/gate/answer.h"

// What the room that an object takes up and the stuff that an answer names leave open for its mass, whatever
// it is called. Pure; any thread.

namespace livegs {

// The least that a thing of this size and stuff weighs, kilograms, for a metric scale: the air of its box;
// for what is blown, rolled, spun or woven thin the thinnest film on every face that is seen, and nothing
// where its surface is drawn thicker than it is. 0: nothing is known.
double min_mass_kg(const Answer& answer, const ObjectFacts& facts);

// Whether the materials that it names take up more room than there is, or too little for what it says of the
// filling: why, one line for a person; empty: neither.
std::string mass_at_odds(const Answer& answer, const ObjectFacts& facts);

// The materials of its largest parts.
std::string materials_of(const Answer& answer);

}  // namespace livegs

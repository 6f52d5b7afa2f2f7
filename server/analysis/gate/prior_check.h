// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "analysis/estimate.h"
#include "analysis/gate/answer.h"

// Step 8 of the gate (gate.h). `proposal` holds the answer after its fusion (step 7) with `offline`, the
// current values of the object.

namespace livegs {

// Compares a proposal with the prior and checks its consistency. Returns the reason for a review as one line,
// or "" if none.
//
// Mass and E* = s E are held by their likelihood under the classes of the tables, with one threshold.
//
// E* and behaviour are those of the proposal, so that a null in the answer is checked as well. They are
// compared with all meanings of the name, for any uncertainty of scale. Without a known name they are not
// compared. A material has no check of its own: mass and E* follow from it.
std::string check_prior(const Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                        const v1::PhysicalParameters& proposal);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "analysis/estimate.h"
#include "analysis/gate/answer.h"

// Step 8 of the gate. `proposal` is what the answer comes to, fused with `offline`, what the object has now.

namespace livegs {

// Far from what was known, or at odds with itself in what it would install: why, one line; empty when it is
// neither. E* = s E, behaviour and material are those of the proposal, so that a null in the answer hides
// nothing. They are held against all that the name may mean, however uncertain the scale is; where no name is
// known, against nothing.
std::string check_prior(const Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                        const v1::PhysicalParameters& proposal);

}  // namespace livegs

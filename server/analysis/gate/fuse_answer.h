// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/estimate/log_normal.h"
#include "analysis/estimate/object_classes.h"
#include "analysis/gate/answer.h"

namespace livegs {

// The estimate that a range of 90 % states; a single number counts as uncertain by a third. Precondition:
// best > 0.
LogNormal log_normal_of(const Span3& range);

// Classes that a name in the answer may mean, at the measured size. A replica may have the name of its
// original: an imitation of a lemon is a plastic fruit. Of several alternatives, the names state which one is
// an imitation.
ObjectClasses answered_classes(const Answer& answer, const std::string& name, const ObjectFacts& facts);
// False if the tables do not have the name; the classes are then those of the appearance.
bool is_named(const ObjectClasses& classes);

// Step 7 of the gate (gate.h): the values of an object after a validated answer.
//
// Applies the answer to all values that are not locked (source SCENE or PERSON), clamped to their hard
// ranges. Mass is fused, by inverse variance in logarithms, with the table values of the object that the
// answer names, at the measured size. It is not fused if the tables do not have this object. E is fused with
// the table's if both name the same class of material. `changes` gets a line for each value that differs from
// the answer. Pure.
v1::PhysicalParameters fuse_answer(const Answer& answer, const ObjectFacts& facts,
                                   const v1::PhysicalParameters& offline, std::vector<std::string>& changes);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "analysis/gate/answer.h"

// Parts of an answer as a list that a user can read and edit: few, each with a name of its own. Pure.

namespace livegs {

// Names parts without a name by their material. Joins parts of one name, material and holder, such as the
// legs of a chair, to one part with all their boxes. Other equal names get a number. Case does not matter.
// `changes` gets a line for what was joined, and one for what was renamed. The order is that of the first of
// each.
void join_equal_parts(std::vector<AnswerPart>& parts, std::vector<std::string>& changes);

// Keeps at most `most` parts, those with the largest shares. The others are added to the largest kept part of
// their material, else to the largest of all, so that the shares keep their sum. `changes` gets a line if
// there are such. Precondition: largest share first, most > 0.
void limit_parts(std::vector<AnswerPart>& parts, size_t most, std::vector<std::string>& changes);

}  // namespace livegs

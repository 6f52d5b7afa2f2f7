// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>
#include <vector>

#include "server/analysis/estimate/known_objects.h"
#include "server/analysis/knowledge/table_things.h"

namespace livegs {

// Standard deviation of ln(mass) of an answer in the style of the trial of November 2026: a mean error of 12
// %. Its stated range is that of 90 %.
inline constexpr double kAnswerSd = 0.15;

// An answer about an object of this true mass, with an error of kAnswerSd. It names the right thing and the
// material and behaviour that the tables have for it.
nlohmann::json replayed_answer(const std::string& name, double true_kg, const ObjectFacts& facts,
                               std::mt19937_64& random);

// `repeats` answers about each object, through the gate. NameGiven::Label: the object has its label, and the
// answer repeats it; otherwise the object has no name, and the answer has its noun. The masses are those that
// the object has afterwards: the offline ones where an answer is refused or only proposed.
std::vector<MassAnswer> replay_answers(const std::vector<KnownObject>& objects, NameGiven name, int repeats);

}  // namespace livegs

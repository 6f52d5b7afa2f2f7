// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "analysis/model/conversation.h"

namespace livegs {

// The slots of a question with those that tools can fill and nobody gave: mesh, category, materials,
// neighbours. With these in the prompt a model needs no tool for an ordinary object, which saves a round
// trip.
std::map<std::string, std::string> complete_slots(const AnalysisQuestion& question, const ToolBox& tools);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "analysis/model/conversation.h"

namespace livegs {

// Slots of a question, completed by those that tools provide: mesh, category, materials, neighbours. With
// them in the prompt a model needs no tool call for an ordinary object, which saves a round trip.
std::map<std::string, std::string> complete_slots(const AnalysisQuestion& question, const ToolBox& tools);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <span>
#include <string>

#include "analysis/estimate.h"
#include "analysis/model/tool_box.h"
#include "analysis/text/message_templates.h"

namespace livegs {

// Maximum number of known neighbours in a prompt.
inline constexpr size_t kMaxNeighbourSlots = 3;

// Known facts of an object as text for the slots of prompts/user.md: name, size, scale, mesh, looks,
// category, neighbours, told (not camera, which belongs to a view).
//
// Slots without facts are absent. Sizes are in metres and centimetres, masses in grams, as in the answer.
// `offline` holds the object's current values; only those of a person or the scene's author are sent, because
// the gate fuses the answer with the tables. `neighbours` are in order of analysis, oldest first; the nearest
// known ones get a line each, with a quoted name. The object's own name is unquoted; the caller quotes it.
// Texts are from prompts/facts.json.
std::map<std::string, std::string> fact_slots(const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                                              std::span<const SceneObjectFacts> neighbours,
                                              const MessageTemplates& words = MessageTemplates::built_in());

}  // namespace livegs

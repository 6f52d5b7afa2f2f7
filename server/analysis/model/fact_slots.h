// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <span>
#include <string>

#include "analysis/estimate.h"
#include "analysis/model/tool_box.h"
#include "analysis/text/message_templates.h"

namespace livegs {

// How many objects that were analysed before are told of.
inline constexpr size_t kMaxNeighbourSlots = 12;

// What is known of an object, as text for the slots of prompts/user.md: name, size, scale, mesh, looks,
// neighbours, materials, offline (not camera, which belongs to a view). Slots of which nothing is known are
// left out. Sizes in metres and centimetres, masses in grams, moduli in MPa, as a model is asked to answer.
// `neighbours` in the order they were analysed, oldest first: the newest kMaxNeighbourSlots are told, a line
// each, its name quoted. The object's own name is as given: who fills the prompt quotes it.
// The words between the figures are those of prompts/facts.json.
std::map<std::string, std::string> fact_slots(const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                                              std::span<const SceneObjectFacts> neighbours,
                                              const MessageTemplates& words = MessageTemplates::built_in());

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "analysis/text/message_templates.h"
#include "core/result.h"

namespace livegs {

// The one JSON object with a "mass_g" in a text, which may stand among prose or in a fence. Any bytes.
// Errors, in the words of prompts/complaints.json: too long, not UTF-8, nested too deep, no such object, more
// than one that differ.
Result<nlohmann::json> answer_object(std::string_view text,
                                     const MessageTemplates& words = MessageTemplates::built_in());

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "analysis/text/message_templates.h"
#include "core/result.h"

namespace livegs {

// Extracts the one JSON object with a "mass_g" from a text, also within prose or a fence. Accepts any bytes.
// Errors, as lines of prompts/complaints.json: too long, not UTF-8, nested too deeply, no such object,
// several different ones.
Result<nlohmann::json> answer_object(std::string_view text,
                                     const MessageTemplates& words = MessageTemplates::built_in());

}  // namespace livegs

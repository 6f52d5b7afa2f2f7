// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "analysis/model/conversation.h"
#include "analysis/text/json_text.h"

// The JSON form of a RawAnswer, in the answer cache and in recordings. `blind` is written only where it is
// true.

namespace livegs {

OrderedJson raw_answer_json(const RawAnswer& answer);
// nullopt without a text "json". Other members that are missing or of another type get their defaults.
std::optional<RawAnswer> read_raw_answer(const Json& json);

}  // namespace livegs

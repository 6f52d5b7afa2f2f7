// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "analysis/model/conversation.h"
#include "analysis/text/json_text.h"

// JSON form of a RawAnswer, for the answer cache and recordings. `blind` is written only if true.

namespace livegs {

OrderedJson raw_answer_json(const RawAnswer& answer);
// nullopt without a string "json". Other missing or mistyped members get their defaults.
std::optional<RawAnswer> read_raw_answer(const Json& json);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <set>
#include <string>
#include <string_view>

#include "core/result.h"

// The {{slots}} of a text of prompts/, so that one that a person has mistyped is told instead of being left
// out in silence.

namespace livegs {

using SlotNames = std::set<std::string, std::less<>>;

// Those that stand in the text.
SlotNames slots_of(std::string_view text);

// Fails on the first slot that is not one of `known`, that names none or that has no end; one line: which
// line of the text, the slot, what to do. In a text that is never filled (`known` empty) only what looks like
// a slot counts, {{lower_case}}.
Result<void> check_slots(std::string_view text, const SlotNames& known);

// The one of `known` that a person may have meant, or "".
std::string meant_word(std::string_view word, const SlotNames& known);

}  // namespace livegs

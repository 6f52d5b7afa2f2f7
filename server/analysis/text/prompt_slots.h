// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <set>
#include <string>
#include <string_view>

#include "core/result.h"

// Validation of the {{slots}} in the texts of prompts/: a mistyped slot is reported instead of silently left
// out.

namespace livegs {

using SlotNames = std::set<std::string, std::less<>>;

// Returns the slots in the text.
SlotNames slots_of(std::string_view text);

// Fails on the first slot that is not in `known`, is unnamed or unclosed. The error is one line with the line
// number, the slot and the remedy. In a text without slots (`known` empty) only {{lower_case}} is treated as
// a slot.
Result<void> check_slots(std::string_view text, const SlotNames& known);

// Returns the member of `known` that was probably meant, or "".
std::string meant_word(std::string_view word, const SlotNames& known);

}  // namespace livegs

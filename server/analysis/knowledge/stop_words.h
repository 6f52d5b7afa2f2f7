// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

// Words of names that are not the thing itself. A name's last noun says what it is ("bird cage"), unless what
// stands there is no noun.

namespace livegs {

// Says nothing of what the thing is: a colour, a state, a place, a word of files and captures, a stray
// letter.
bool is_stop_word(std::string_view word);

// After a noun it makes another thing of it: the cage of a bird, the case of a violin.
bool is_head_noun(std::string_view word);

// What stands behind it is not the thing: "cup with a lid". "of" is not among them.
bool is_preposition(std::string_view word);

}  // namespace livegs

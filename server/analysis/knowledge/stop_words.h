// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

// Words in names that do not name the object. The last noun of a name is the object ("bird cage"), unless the
// last word is not a noun.

namespace livegs {

// True for words without information about the object: colours, states, places, words of files and captures,
// single letters.
bool is_stop_word(std::string_view word);

// True for nouns that form another object with the noun before them: bird cage, violin case.
bool is_head_noun(std::string_view word);

// True for prepositions before words that are not the object: "cup with a lid". Excludes "of".
bool is_preposition(std::string_view word);

}  // namespace livegs

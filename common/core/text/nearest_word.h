// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace livegs {

// Damerau-Levenshtein distance: an exchange of two adjacent characters is one step.
std::size_t edit_distance(std::string_view a, std::string_view b);

// The word with the smallest distance to `word`, without regard to case; the first of several. Empty if none
// is nearer than a third of the length, and at least one step.
std::string_view nearest_word(std::string_view word, std::span<const std::string> words);

}  // namespace livegs

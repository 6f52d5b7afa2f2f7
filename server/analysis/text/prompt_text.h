// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace livegs {

// Quotes untrusted text of an object for a prompt: double quotes, at most `longest` characters, without
// control characters, quotes or angle brackets. The text can neither end its line nor imitate its
// surroundings.
std::string quoted_text(std::string_view text, std::size_t longest = 80);
// The same without quotes, for untrusted text within a trusted line.
std::string line_text(std::string_view text, std::size_t longest = 80);
// Quotes a trusted line; braces and angle brackets are kept. Untrusted parts must have passed line_text().
std::string quoted_line(std::string_view line, std::size_t longest);

// Sanitises facts: removes control characters except newlines, breaks up runs of dashes that could end the
// data, and truncates at `longest` bytes.
std::string plain_text(std::string_view text, std::size_t longest = 4000);

// Replaces each `{{slot}}` by the result of `value_of`, in one pass; inserted values are not scanned again.
std::string fill_line(std::string_view line,
                      const std::function<std::string(std::string_view slot)>& value_of);
// Fills the slots line by line. A line with an absent or empty slot is left out.
std::string fill_slots(std::string_view text, const std::map<std::string, std::string>& slots);

}  // namespace livegs

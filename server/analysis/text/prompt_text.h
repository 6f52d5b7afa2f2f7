// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace livegs {

// A name or a text of an object as a model may see it: in double quotes, at most `longest` characters,
// without control characters, quotes or angle brackets, so that it can neither end its line nor imitate what
// stands around it.
std::string quoted_text(std::string_view text, std::size_t longest = 80);
// The same without the quotes around it: a text from anybody as a part of a line of our own.
std::string line_text(std::string_view text, std::size_t longest = 80);
// A line of our own in double quotes: braces and angle brackets stay as they are written. What others gave it
// must have come into it by line_text.
std::string quoted_line(std::string_view line, std::size_t longest);

// Facts: control characters but newlines left out, runs of dashes that could end the data broken up, cut at
// `longest` bytes.
std::string plain_text(std::string_view text, std::size_t longest = 4000);

// `{{slot}}` by what `value_of` gives for it, in one pass: values are not looked at again.
std::string fill_line(std::string_view line,
                      const std::function<std::string(std::string_view slot)>& value_of);
// The same line by line. One with a slot that is absent or empty is left out.
std::string fill_slots(std::string_view text, const std::map<std::string, std::string>& slots);

}  // namespace livegs

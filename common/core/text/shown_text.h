// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

// Text of users, files and models in messages: one line that shows what it is. Any bytes, any thread.

namespace livegs {

// Without control characters, invisible characters and invalid UTF-8; at most `characters` long.
std::string shown_text(std::string_view text, size_t characters);

// The same for a name or a short line.
inline std::string shown_line(std::string_view text) { return shown_text(text, 80); }

// The same in double quotes; "…" at the end of a text that was cut.
std::string quoted_name(std::string_view text, size_t characters = 64);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace livegs {

// The message with every absolute path reduced to its last component, so that clients do not see the server's
// folders. A path starts at the start of a word and ends before ": ", a quote, "; ", " /" or the end, so
// folder names with spaces are removed too. The caller logs the full message.
std::string redact_paths(std::string_view message);

}  // namespace livegs

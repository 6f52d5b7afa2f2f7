// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace livegs {

// A message as a client may read it: of every absolute path its last part alone, since where a server keeps
// its files is nobody's business. A path begins where a word does and ends before ": ", a quote, "; ", " /"
// or the end, so folders with spaces in their names go too. Who tells a client so has the log keep the
// message as it was.
std::string redact_paths(std::string_view message);

}  // namespace livegs

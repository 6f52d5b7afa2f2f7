// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/support/redact_paths.h"

#include <algorithm>

namespace livegs {
namespace {

bool ends_word(char c) { return c == ' ' || c == '"' || c == '\'' || c == '(' || c == '='; }

}  // namespace

std::string redact_paths(std::string_view message) {
  std::string redacted;
  for (size_t at = 0; at < message.size();) {
    const bool begins = message[at] == '/' && (at == 0 || ends_word(message[at - 1]));
    if (!begins) {
      redacted += message[at++];
      continue;
    }
    size_t end = message.size();
    for (const std::string_view stop : {": ", "; ", "\"", "'", " /"})
      end = std::min(end, message.find(stop, at + 1));
    const std::string_view path = message.substr(at, end - at);
    const size_t slash = path.find_last_of('/', path.find_last_not_of('/'));
    // A single slash is not a path.
    redacted +=
        slash == std::string_view::npos || path.size() < 2 || path[1] == ' ' ? path : path.substr(slash + 1);
    at = end;
  }
  return redacted;
}

}  // namespace livegs

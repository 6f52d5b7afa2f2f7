// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

// Fewest digits of an abbreviated id; fewer are likely to be a mistake.
inline constexpr size_t kMinIdDigits = 4;

// Index of the only id that starts with `prefix`; a whole id is preferred. InvalidArgument for fewer than
// kMinIdDigits digits or for several ids, NotFound for none. `thing` names one in the errors ("session"),
// `list` the command that lists them.
inline Result<size_t> find_by_prefix(std::span<const std::string> ids, std::string_view prefix,
                                     const std::string& thing, const std::string& list) {
  if (prefix.size() < kMinIdDigits)
    return invalid_argument(thing + ": id is too short; give four or more digits");
  size_t found = ids.size();
  for (size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] == prefix) return i;
    if (!ids[i].starts_with(prefix)) continue;
    if (found < ids.size())
      return invalid_argument(thing + ": several ids start with \"" + std::string(prefix) +
                              "\"; give more digits");
    found = i;
  }
  if (found < ids.size()) return found;
  return not_found(thing + ": no id starts with \"" + std::string(prefix.substr(0, 40)) + "\"; run " + list +
                   " to list them");
}

}  // namespace livegs

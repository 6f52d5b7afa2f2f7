// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace livegs {

// Lower case of the ASCII letters; other bytes, such as those of UTF-8, are kept.
inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

// Whether a file name ends in `ending`, in any letter case: cameras and copies from other systems write .PLY
// and .Spz. `ending` is in lower case.
inline bool has_ending(std::string_view name, std::string_view ending) {
  return name.size() >= ending.size() && lower_case(name.substr(name.size() - ending.size())) == ending;
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "core/text/lower_case.h"

namespace livegs {

// Whether a file name ends in `ending`, in any letter case: cameras and copies from other systems write .PLY
// and .Spz. `ending` is in lower case.
inline bool has_ending(std::string_view name, std::string_view ending) {
  return name.size() >= ending.size() && lower_case(name.substr(name.size() - ending.size())) == ending;
}

}  // namespace livegs

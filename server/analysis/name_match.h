// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "analysis/knowledge.h"

namespace livegs {

// A name as it is compared: lower case, digits and separators to single spaces, "lego_house_50k" to "lego
// house k".
std::string normalised_name(std::string_view name);

// The row of the object table a name speaks of, and by which of its names: the longest whose words all stand
// together in the name, a plural s allowed; ties go to the one that ends last. A word for a class of materials
// ("wood", "glass") counts only where nothing else does. `row` is null when there is none.
struct NameMatch {
  const ObjectRow* row = nullptr;
  std::string alias;
};
NameMatch match_name(std::string_view name);

// A material named outright ("marble_bust"), or by a word for its class ("wooden"), which says less: null
// when there is none.
struct MaterialMatch {
  const MaterialRow* row = nullptr;
  bool outright = false;
};
MaterialMatch match_material(std::string_view name);

}  // namespace livegs

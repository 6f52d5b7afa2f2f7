// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "analysis/knowledge.h"

namespace livegs {

// A name as it is compared: lower case, digits and separators to single spaces, "lego_house_50k" to "lego house k".
std::string normalised_name(std::string_view name);

// The row of the object table a name speaks of: the longest alias whose words all stand together in the name, a plural
// s allowed; ties go to the one that ends last ("wooden stool" is a stool). Null when there is none.
const ObjectRow* match_name(std::string_view name);

// A material named outright ("marble_bust"): its class and row; null when there is none.
const MaterialRow* match_material(std::string_view name);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "analysis/knowledge/tables.h"

namespace livegs {

// A name as it is compared: lower case, plain letters, digits and separators to single spaces,
// "lego_house_50k" to "lego house k".
std::string normalised_name(std::string_view name);

// The row of the object table a name speaks of, and by which of its names. All its words stand together in
// the name, a plural s or es allowed, "hotdog" for "hot dog" and the other way round. The one that ends the
// name is the thing
// ("kitchen scale", "curtain rod"), of several the longest; what stands behind a preposition is not ("cup
// with a lid"), and of "can of tuna" it is the tuna that has a row of its own. A word for a class of
// materials ("wood", "glass") counts only where nothing else does. `row` is null when there is none.
struct NameMatch {
  const ObjectRow* row = nullptr;
  std::string alias;
  // What stands behind it in the name, but for colours and the like. Of a "cake stand" the cake says little,
  // of a "mug tuesday" the mug a lot.
  enum class Tail { Nothing, Unknown, AnotherThing };
  Tail tail = Tail::Nothing;
  std::string tail_words;  // "stand"; empty for Nothing
};
NameMatch match_name(std::string_view name);

// A material named outright ("marble_bust"), or by a word for its class ("wooden"), which says less: null
// when there is none.
struct MaterialMatch {
  const MaterialRow* row = nullptr;
  bool outright = false;
};
MaterialMatch match_material(std::string_view name);

// The longest side, in metres, that an object of this name usually has: {low, best, high}; all zero when the
// name says nothing. Used to guess the scale of an asset that is not metric.
struct SizePrior {
  double low_m = 0, best_m = 0, high_m = 0;
  std::string label;
};
SizePrior size_prior(std::string_view name);

}  // namespace livegs

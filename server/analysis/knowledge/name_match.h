// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "analysis/knowledge/tables.h"

namespace livegs {

// Normalises a name for comparison: lower case, no diacritics, digits and separators replaced by single
// spaces. "lego_house_50k" becomes "lego house k".
std::string normalised_name(std::string_view name);

// Object row matched by a name, and the alias that matched.
//
// The words of an alias must be adjacent in the name. A plural s or es is allowed, and so is "hotdog" for
// "hot dog" and the reverse. Rules of precedence:
// - The last alias is the object ("kitchen scale", "curtain rod"); of several, the longest.
// - Words after a preposition are not the object ("cup with a lid"). "can of tuna" matches tuna, which has a
//   row of its own.
// - A word for a class of materials ("wood", "glass") is used only if nothing else matches.
// `row` is null if nothing matches.
struct NameMatch {
  const ObjectRow* row = nullptr;
  std::string alias;
  // Words after the alias, except colours and similar ones. AnotherThing ("cake stand") makes the match weak;
  // Unknown ("mug tuesday") weakens it little.
  enum class Tail { Nothing, Unknown, AnotherThing };
  Tail tail = Tail::Nothing;
  std::string tail_words;  // "stand"; empty for Nothing
};
NameMatch match_name(std::string_view name);

// Material matched by a name ("marble_bust"), or by a word for its class ("wooden"), which is weaker. `row`
// is null if nothing matches.
struct MaterialMatch {
  const MaterialRow* row = nullptr;
  bool outright = false;
};
MaterialMatch match_material(std::string_view name);

// Usual longest side, in metres, of an object of this name: {low, best, high}; all zero if the name is
// unknown. Used to guess the scale of an asset that is not metric.
struct SizePrior {
  double low_m = 0, best_m = 0, high_m = 0;
  std::string label;
};
SizePrior size_prior(std::string_view name);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/estimate/object_classes.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

// Odds factor of a class whose material class the name also states ("metal bowl").
constexpr double kNamedMaterialOdds = 30;
// Bound of the likelihood ratio by which size and shape change the probabilities of a name.
constexpr double kMaxLikelihoodRatio = 50;

bool has_named_material(const ObjectClasses& found, const ObjectRow& row) {
  return material_row(row.material).material_class == found.material.row->material_class;
}

void normalise(std::vector<ObjectClass>& kinds) {
  double sum = 0;
  for (const ObjectClass& kind : kinds) sum += kind.probability;
  for (ObjectClass& kind : kinds) kind.probability = sum > 0 ? kind.probability / sum : 1.0 / kinds.size();
  std::stable_sort(kinds.begin(), kinds.end(),
                   [](const ObjectClass& a, const ObjectClass& b) { return a.probability > b.probability; });
}

// Row of an imitation: "toy hammer", "artificial lemon".
const ObjectRow* replica_row(const ObjectRow& row, const std::string& rest) {
  if (row.category == "toy" || row.category == "replica" || row.category == "ball") return nullptr;
  const std::string words = ' ' + rest + ' ';
  for (const char* word :
       {" toy ", " fake ", " artificial ", " replica ", " miniature ", " imitation ", " pretend "}) {
    if (words.find(word) == std::string::npos) continue;
    const bool food = row.category == "fruit" || row.category == "food";
    const ObjectRow* replica = find_object_row(food ? "plastic fruit" : "toy");
    // A toy of plastic is the thing itself: a toy stacking cup is a stacking cup.
    const auto material_class = [](const ObjectRow& one) {
      return material_row(one.material).material_class;
    };
    return material_class(row) == material_class(*replica) ? nullptr : replica;
  }
  return nullptr;
}

// The name without the matched words: "apple" does not also state the material apple.
std::string without(std::string words, const std::string& alias) {
  const size_t at = words.find(alias);
  return at == std::string::npos ? words : words.erase(at, alias.size());
}

void kinds_by_name(const ObjectFacts& facts, ObjectClasses& found) {
  const ObjectRow& row = *found.match.row;
  const std::string rest_of_name = without(normalised_name(facts.name), found.match.alias);
  found.material = match_material(rest_of_name);
  if (const ObjectRow* replica = replica_row(row, rest_of_name)) {
    found.kinds = {{replica, 1, nullptr}};
    return;
  }
  double rest = 1;
  for (const ObjectAlternative& alternative : row.alternatives) rest -= alternative.probability;
  found.kinds = {{&row, rest, nullptr}};
  for (const ObjectAlternative& alternative : row.alternatives) {
    found.kinds.push_back({find_object_row(alternative.label), alternative.probability, nullptr});
  }
  if (found.material.row && row.fill != v1::Physics::FILLED) {
    const bool any = std::any_of(found.kinds.begin(), found.kinds.end(), [&](const ObjectClass& kind) {
      return has_named_material(found, *kind.row);
    });
    for (ObjectClass& kind : found.kinds) {
      if (any && has_named_material(found, *kind.row)) kind.probability *= kNamedMaterialOdds;
      // "wooden" adds nothing for a class that is wood by default; "oak" does.
      const bool differs = found.material.outright ? found.material.row->name != kind.row->material
                                                   : !has_named_material(found, *kind.row);
      if (differs && (!any || has_named_material(found, *kind.row))) kind.material = found.material.row;
    }
  }
  if (found.kinds.size() < 2) {
    found.kinds.front().probability = 1;
    return;
  }
  // The first meaning of a name may have any size; its other meanings must fit.
  double most = 0;
  std::vector<double> fits;
  for (const ObjectClass& kind : found.kinds) {
    // A replica has the size and shape of its original.
    fits.push_back(kind_likelihood(kind.row->category == "replica" ? row : *kind.row, facts));
    most = std::max(most, fits.back());
  }
  for (size_t i = 0; i < fits.size(); ++i) {
    found.kinds[i].probability *= most > 0 ? std::max(fits[i] / most, 1 / kMaxLikelihoodRatio) : 1;
  }
  normalise(found.kinds);
}

// Weight of a name whose last word is not in the table. An unknown word may be a place or a person: a "mug
// tuesday" is a mug. A word that forms another object leaves almost no weight. Judgements.
constexpr double kTailUnknown = 0.5, kTailOther = 0.05;

// Relative frequency of a class in rooms and captures. A judgement.
double commonness(const ObjectRow& row) {
  if (row.category == "package") return 2;
  if (row.category == "living" || row.category == "vehicles") return 0.3;
  for (const char* rare : {"clothes", "music", "sport", "outdoors"}) {
    if (row.category == rare) return 0.5;
  }
  return 1;
}

void kinds_by_looks(const ObjectFacts& facts, ObjectClasses& found) {
  for (const ObjectRow& row : object_table()) {
    double weight = commonness(row) * kind_likelihood(row, facts);
    if (found.material.row && has_named_material(found, row)) weight *= kNamedMaterialOdds;
    found.kinds.push_back({&row, weight, nullptr});
  }
  normalise(found.kinds);
  // Negligible classes are removed.
  size_t kept = 0;
  double sum = 0;
  while (kept < found.kinds.size() && sum < 0.995) sum += found.kinds[kept++].probability;
  found.kinds.resize(kept);
  normalise(found.kinds);
  if (!found.material.row || !found.material.outright) return;
  for (ObjectClass& kind : found.kinds) {
    if (has_named_material(found, *kind.row) && kind.row->material != found.material.row->name)
      kind.material = found.material.row;
  }
}

}  // namespace

ObjectClasses object_classes(const ObjectFacts& facts) {
  ObjectClasses found;
  found.match = match_name(facts.name);
  found.material = match_material(facts.name);
  if (!found.match.row) {
    kinds_by_looks(facts, found);
    return found;
  }
  kinds_by_name(facts, found);
  if (found.match.tail == NameMatch::Tail::Nothing) return found;
  const double believed = found.match.tail == NameMatch::Tail::Unknown ? kTailUnknown : kTailOther;
  ObjectClasses by_looks;
  by_looks.material = found.material;
  kinds_by_looks(facts, by_looks);
  for (ObjectClass& kind : found.kinds) kind.probability *= believed;
  for (ObjectClass& kind : by_looks.kinds) {
    kind.probability *= 1 - believed;
    found.kinds.push_back(kind);
  }
  normalise(found.kinds);
  return found;
}

}  // namespace livegs

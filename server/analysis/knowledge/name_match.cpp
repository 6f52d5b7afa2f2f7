// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/knowledge/name_match.h"

#include <algorithm>
#include <cctype>
#include <tuple>
#include <vector>

#include "analysis/knowledge/stop_words.h"
#include "analysis/text/fold_diacritics.h"

namespace livegs {
namespace {

// Position of `words` in `text` as whole words, a plural allowed: start and end, or npos.
struct Place {
  size_t begin = std::string::npos, end = 0;
  bool found() const { return begin != std::string::npos; }
};
Place find_words(const std::string& text, const std::string& words) {
  Place last;
  const bool hisses = words.ends_with("sh") || words.ends_with("ch") ||
                      std::string_view("sxzo").find(words.back()) != std::string::npos;
  for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
    if (at != 0 && text[at - 1] != ' ') continue;
    for (const std::string_view plural : {"", "s", "es"}) {
      if (plural == "es" && !hisses) continue;
      const size_t end = at + words.size() + plural.size();
      if (text.compare(at + words.size(), plural.size(), plural) != 0) continue;
      if (end == text.size() || text[end] == ' ') last = {at, end};
    }
  }
  return last;
}

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    if (end > begin) words.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

std::string joined(std::string words) {
  std::erase(words, ' ');
  return words;
}

// Position of an alias whose words are joined or split in the name: "hotdog" for "hot dog", "bird house" for
// "birdhouse". Aliases shorter than this are skipped because they occur by chance.
constexpr size_t kMinJoinedLength = 6;
Place find_joined(const std::string& text, const std::string& alias) {
  const std::string together = joined(alias);
  if (together.size() < kMinJoinedLength) return {};
  if (together != alias) return find_words(text, together);
  size_t begin = 0;
  const std::vector<std::string> words = words_of(text);
  for (size_t i = 0; i + 1 < words.size(); ++i) {
    if (words[i] + words[i + 1] == alias) return {begin, begin + alias.size() + 1};
    begin += words[i].size() + 1;
  }
  return {};
}

// Common words for a whole class of materials.
constexpr std::pair<const char*, const char*> kClassWords[] = {{"fur", "plush"},
                                                               {"wooden", "hardwood"},
                                                               {"wood", "hardwood"},
                                                               {"metal", "aluminium"},
                                                               {"steel", "carbon steel"},
                                                               {"glass", "soda-lime glass"},
                                                               {"ceramic", "stoneware"},
                                                               {"clay", "terracotta"},
                                                               {"stone", "granite"},
                                                               {"plastic", "polypropylene"},
                                                               {"rubber", "natural rubber"},
                                                               {"felt", "wool felt"},
                                                               {"bronze", "brass"},
                                                               {"foam", "polyurethane foam"},
                                                               {"fabric", "cotton fabric"},
                                                               {"paper", "paper stack"}};

bool names_a_class(const std::string& alias) {
  return std::any_of(std::begin(kClassWords), std::end(kClassWords),
                     [&](const auto& word) { return alias == word.first; });
}

// True for "leather" or "metal": the word names a material, not an object.
bool names_a_material(const std::string& word) {
  const MaterialRow* row = find_material_row(word);
  if (!row) return names_a_class(word);
  for (const char* of :
       {"metal", "stone", "wood", "glass", "ceramic", "plastic", "elastomer", "foam", "textile"}) {
    if (row->material_class == of) return true;
  }
  return false;
}

// An alias found in a name.
struct Found {
  const ObjectRow* row = nullptr;
  const std::string* alias = nullptr;
  Place place;
  bool exact = true;  // false if its words are joined or split in the name
  size_t part = 0;    // index of the part of the name, split at prepositions; the first is the object
  NameMatch::Tail tail = NameMatch::Tail::Nothing;
  std::string tail_words;
};

void look_behind(const std::string& part_of_name, size_t from, Found& found) {
  for (const std::string& word :
       words_of(std::string_view(part_of_name).substr(std::min(from, part_of_name.size())))) {
    if (is_stop_word(word) || names_a_material(word)) continue;
    // The last word decides.
    found.tail = is_head_noun(word) ? NameMatch::Tail::AnotherThing : NameMatch::Tail::Unknown;
    found.tail_words += (found.tail_words.empty() ? "" : " ") + word;
  }
}

// True if `a` identifies the object better than `b`.
bool better(const Found& a, const Found& b) {
  const auto weight = [](const Found& one) {
    const bool ends = one.tail == NameMatch::Tail::Nothing;
    const size_t size = one.exact ? one.alias->size() : joined(*one.alias).size(), end = one.place.end;
    // "wood" alone is a block; a "wood bed" is a bed.
    return std::tuple(!names_a_class(*one.alias), ~one.part, ends, ends ? size : end, ends ? end : size,
                      one.exact);
  };
  return weight(a) > weight(b);
}

// Starts of the parts of a name: "can of tuna on a table" has "can", "of tuna" and "on a table".
struct Part {
  size_t begin = 0, end = 0;
  bool of = false;
};
std::vector<Part> parts_of(const std::string& words) {
  std::vector<Part> parts = {{}};
  size_t begin = 0;
  for (const std::string& word : words_of(words)) {
    if (is_preposition(word) || word == "of") {
      parts.back().end = begin;
      parts.push_back({begin + word.size(), 0, word == "of"});
    }
    begin += word.size() + 1;
  }
  parts.back().end = words.size();
  return parts;
}

// True for containers, whose contents follow "of", and for packed goods, whose row includes the package.
bool holds_things(const ObjectRow& row) { return row.category == "package" || row.category == "bags"; }
bool is_packed(const ObjectRow& row) { return row.category == "package"; }

}  // namespace

std::string normalised_name(std::string_view name) {
  std::string words;
  char before = ' ';
  for (const char raw : fold_diacritics(name.substr(0, 200))) {
    const auto letter = static_cast<unsigned char>(raw);
    const bool camel = std::isupper(letter) && std::islower(static_cast<unsigned char>(before));
    if (camel || !std::isalpha(letter)) {
      if (!words.empty() && words.back() != ' ') words += ' ';
    }
    if (std::isalpha(letter)) words += static_cast<char>(std::tolower(letter));
    before = raw;
  }
  while (!words.empty() && words.back() == ' ') words.pop_back();
  return words;
}

NameMatch match_name(std::string_view name) {
  const std::string words = normalised_name(name);
  const std::vector<Part> parts = parts_of(words);
  std::vector<Found> best(parts.size());  // per part
  for (const ObjectRow& row : object_table()) {
    for (const std::string& alias : row.names) {
      Found found;
      found.row = &row;
      found.alias = &alias;
      found.place = find_words(words, alias);
      found.exact = found.place.found();
      if (!found.exact) found.place = find_joined(words, alias);
      if (!found.place.found()) continue;
      while (found.part + 1 < parts.size() && parts[found.part + 1].begin <= found.place.begin) ++found.part;
      look_behind(words.substr(0, parts[found.part].end), found.place.end, found);
      Found& other = best[found.part];
      if (!other.row || better(found, other)) other = std::move(found);
    }
  }
  const Found* thing = nullptr;
  for (const Found& found : best) {
    if (found.row && (!thing || better(found, *thing))) thing = &found;
  }
  if (!thing) return {};
  // Packed goods have a row of their own with the filled mass: a can of tuna.
  const size_t next = thing->part + 1;
  const bool holds = holds_things(*thing->row) && thing->place.end <= parts[thing->part].end;
  if (holds && next < parts.size() && parts[next].of && best[next].row && is_packed(*best[next].row))
    thing = &best[next];
  NameMatch match{thing->row, *thing->alias, thing->tail, thing->tail_words};
  // "slice of bread": the object is the word before "of", and it is unknown.
  if (thing->part > 0 && match.tail == NameMatch::Tail::Nothing && !best[thing->part - 1].row) {
    const Part& before = parts[thing->part - 1];
    for (const std::string& word :
         words_of(std::string_view(words).substr(before.begin, before.end - before.begin))) {
      if (is_stop_word(word) || names_a_material(word)) continue;
      match.tail = is_head_noun(word) ? NameMatch::Tail::AnotherThing : NameMatch::Tail::Unknown;
      match.tail_words = word;
    }
  }
  return match;
}

MaterialMatch match_material(std::string_view name) {
  const std::string words = normalised_name(name);
  const MaterialRow* best = nullptr;
  for (const MaterialRow& row : material_table()) {
    if (!find_words(words, normalised_name(row.name)).found()) continue;
    if (!best || row.name.size() > best->name.size()) best = &row;
  }
  if (best) return {best, true};
  for (const auto& [word, material] : kClassWords) {
    if (find_words(words, word).found()) return {&material_row(material), false};
  }
  return {};
}

SizePrior size_prior(std::string_view name) {
  const NameMatch match = match_name(name);
  if (!match.row || match.tail == NameMatch::Tail::AnotherThing) return {};
  return {match.row->size_m.low, match.row->size_m.best, match.row->size_m.high, match.alias};
}

}  // namespace livegs

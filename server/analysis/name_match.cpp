// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/name_match.h"

#include <algorithm>
#include <cctype>
#include <tuple>

#include "analysis/estimate.h"

namespace livegs {
namespace {

// Where `words` stands in `text` as whole words, counted from the text's start; npos if it does not.
size_t find_words(const std::string& text, const std::string& words) {
  for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) {
    const bool starts = at == 0 || text[at - 1] == ' ';
    size_t end = at + words.size();
    if (end < text.size() && text[end] == 's') ++end;
    const bool ends = end == text.size() || text[end] == ' ';
    if (starts && ends) return at;
  }
  return std::string::npos;
}

// Words people use for a whole class of materials.
constexpr std::pair<const char*, const char*> kClassWords[] = {
    {"wooden", "hardwood"},        {"wood", "hardwood"},         {"metal", "aluminium"},
    {"steel", "carbon steel"},     {"glass", "soda-lime glass"}, {"ceramic", "stoneware"},
    {"clay", "terracotta"},        {"stone", "granite"},         {"plastic", "polypropylene"},
    {"rubber", "natural rubber"},  {"felt", "wool felt"},        {"bronze", "brass"},
    {"foam", "polyurethane foam"}, {"fabric", "cotton fabric"},  {"paper", "paper stack"}};

bool names_a_class(const std::string& alias) {
  return std::any_of(std::begin(kClassWords), std::end(kClassWords),
                     [&](const auto& word) { return alias == word.first; });
}

}  // namespace

std::string normalised_name(std::string_view name) {
  std::string words;
  char before = ' ';
  for (const char raw : name.substr(0, 200)) {
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
  NameMatch best;
  size_t best_end = 0;
  for (const ObjectRow& row : object_table()) {
    for (const std::string& alias : row.names) {
      const size_t at = find_words(words, alias);
      if (at == std::string::npos) continue;
      const size_t end = at + alias.size();
      // "wood" alone is a block; a "wood bed" is a bed.
      const auto weight = [](const std::string& one, size_t one_end) {
        return std::tuple(!one.empty() && !names_a_class(one), one.size(), one_end);
      };
      if (weight(alias, end) > weight(best.alias, best_end)) {
        best = {&row, alias};
        best_end = end;
      }
    }
  }
  return best;
}

MaterialMatch match_material(std::string_view name) {
  const std::string words = normalised_name(name);
  const MaterialRow* best = nullptr;
  for (const MaterialRow& row : material_table()) {
    if (find_words(words, normalised_name(row.name)) == std::string::npos) continue;
    if (!best || row.name.size() > best->name.size()) best = &row;
  }
  if (best) return {best, true};
  for (const auto& [word, material] : kClassWords) {
    if (find_words(words, word) != std::string::npos) return {&material_row(material), false};
  }
  return {};
}

SizePrior size_prior(std::string_view name) {
  const NameMatch match = match_name(name);
  if (!match.row) return {};
  return {match.row->size_m.low, match.row->size_m.best, match.row->size_m.high, match.alias};
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/knowledge/table_search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "analysis/knowledge/name_match.h"

namespace livegs {
namespace {

// Usual constants of Okapi BM25.
constexpr double kTermSaturation = 1.2, kLengthWeight = 0.75;
// Scores of a perfect trigram overlap and of a table alias, in units of the BM25 score (2 to 6 for one rare
// word). An alias decides; trigrams matter only if no word matches.
constexpr double kTrigramWeight = 3.0, kAliasWeight = 8.0, kMaterialOfObject = 0.6;
constexpr double kMinTrigramShare = 0.3, kMinScore = 0.6;
constexpr std::size_t kMaxQueryLength = 200;

std::vector<std::string> search_words_of(std::string_view text) {
  std::vector<std::string> words;
  const std::string plain = normalised_name(text);
  for (std::size_t begin = 0; begin < plain.size();) {
    const std::size_t end = std::min(plain.find(' ', begin), plain.size());
    std::string word = plain.substr(begin, end - begin);
    // A plain plural.
    if (word.size() > 3 && word.back() == 's' && word[word.size() - 2] != 's') word.pop_back();
    if (!word.empty()) words.push_back(std::move(word));
    begin = end + 1;
  }
  return words;
}

std::set<std::string> trigrams_of(std::string_view text) {
  const std::string padded = " " + normalised_name(text) + " ";
  std::set<std::string> grams;
  for (std::size_t i = 0; i + 3 <= padded.size(); ++i) grams.insert(padded.substr(i, 3));
  return grams;
}

// Dice's coefficient: 1 for equal sets.
double overlap(const std::set<std::string>& a, const std::set<std::string>& b) {
  if (a.empty() || b.empty()) return 0;
  std::size_t common = 0;
  for (const std::string& gram : a) common += b.count(gram);
  return 2.0 * static_cast<double>(common) / static_cast<double>(a.size() + b.size());
}

struct Document {
  KnowledgeHit row;
  std::map<std::string, int> counts;
  std::size_t length = 0;
  std::vector<std::set<std::string>> names;  // trigrams of each name
};

struct Index {
  std::vector<Document> documents;  // materials, then objects, in the order of the tables
  std::map<std::string, int> documents_with;
  double mean_length = 1;
};

Index build_index() {
  Index index;
  const auto add = [&](KnowledgeHit row, const std::vector<std::string>& names, const std::string& more) {
    Document document;
    document.row = std::move(row);
    std::vector<std::string> words = search_words_of(more);
    for (const std::string& name : names) {
      document.names.push_back(trigrams_of(name));
      for (std::string& word : search_words_of(name)) words.push_back(std::move(word));
    }
    for (const std::string& word : words) ++document.counts[word];
    document.length = words.size();
    for (const auto& [word, count] : document.counts) ++index.documents_with[word];
    index.documents.push_back(std::move(document));
  };
  for (const MaterialRow& row : material_table()) {
    add({"material:" + row.name, &row, nullptr, 0}, {row.name}, row.material_class);
  }
  for (const ObjectRow& row : object_table()) {
    add({"object:" + row.label, nullptr, &row, 0}, row.names, "");
  }
  double total = 0;
  for (const Document& document : index.documents) total += static_cast<double>(document.length);
  index.mean_length = std::max(1.0, total / static_cast<double>(index.documents.size()));
  return index;
}

const Index& index_of_tables() {
  static const Index index = build_index();
  return index;
}

double bm25(const Index& index, const Document& document, const std::vector<std::string>& query) {
  double score = 0;
  for (const std::string& word : query) {
    const auto count = document.counts.find(word);
    if (count == document.counts.end()) continue;
    const double with = index.documents_with.at(word);
    const double all = static_cast<double>(index.documents.size());
    const double rarity = std::log(1.0 + (all - with + 0.5) / (with + 0.5));
    const double frequency = count->second;
    const double length = static_cast<double>(document.length) / index.mean_length;
    score += rarity * frequency * (kTermSaturation + 1) /
             (frequency + kTermSaturation * (1 - kLengthWeight + kLengthWeight * length));
  }
  return score;
}

}  // namespace

std::vector<KnowledgeHit> search_knowledge(std::string_view query, std::size_t count) {
  query = query.substr(0, kMaxQueryLength);
  const Index& index = index_of_tables();
  const std::vector<std::string> words = search_words_of(query);
  const std::set<std::string> grams = trigrams_of(query);
  const NameMatch object = match_name(query);
  const MaterialMatch material = match_material(query);
  std::vector<KnowledgeHit> hits;
  for (const Document& document : index.documents) {
    KnowledgeHit hit = document.row;
    hit.score = bm25(index, document, words);
    double likeness = 0;
    for (const std::set<std::string>& name : document.names)
      likeness = std::max(likeness, overlap(grams, name));
    if (likeness >= kMinTrigramShare) hit.score += kTrigramWeight * likeness;
    if (hit.object && hit.object == object.row) hit.score += kAliasWeight;
    if (hit.material && hit.material == material.row)
      hit.score += kAliasWeight * (material.outright ? 1.0 : 0.8);
    if (hit.material && object.row && object.row->material == hit.material->name) {
      hit.score += kAliasWeight * kMaterialOfObject;
    }
    if (hit.score >= kMinScore) hits.push_back(std::move(hit));
  }
  std::stable_sort(hits.begin(), hits.end(),
                   [](const KnowledgeHit& a, const KnowledgeHit& b) { return a.score > b.score; });
  if (hits.size() > count) hits.resize(count);
  return hits;
}

std::vector<const MaterialRow*> similar_materials(const MaterialRow& material, std::size_t count) {
  // Moduli span nine decades, densities three.
  constexpr double kModulusWeight = 0.3, kOtherClass = 1.0, kOtherFragility = 0.5;
  std::vector<std::pair<double, const MaterialRow*>> others;
  for (const MaterialRow& row : material_table()) {
    if (row.name == material.name) continue;
    const double apart =
        std::abs(std::log(row.density_kg_m3.best / material.density_kg_m3.best)) +
        kModulusWeight * std::abs(std::log(row.youngs_modulus_pa.best / material.youngs_modulus_pa.best)) +
        (row.material_class == material.material_class ? 0 : kOtherClass) +
        (row.fragile == material.fragile ? 0 : kOtherFragility);
    others.push_back({apart, &row});
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const MaterialRow*> nearest;
  for (std::size_t i = 0; i < std::min(count, others.size()); ++i) nearest.push_back(others[i].second);
  return nearest;
}

KnowledgeHit find_knowledge(std::string_view id) {
  for (const Document& document : index_of_tables().documents) {
    const std::string_view full = document.row.id;
    if (id == full || id == full.substr(full.find(':') + 1)) return document.row;
  }
  return {};
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/knowledge/tables.h"

namespace livegs {

// A row of either table: "material:stoneware", "object:mug". One of the pointers is null.
struct KnowledgeHit {
  std::string id;
  const MaterialRow* material = nullptr;
  const ObjectRow* object = nullptr;
  double score = 0;
};

// The rows that words speak of, best first, at most `count`; empty where nothing fits. BM25 over the words of
// names, classes and aliases (Robertson & Zaragoza 2009), the share of common character trigrams for what is
// misspelt or joined, and the tables' own aliases, through which an object also brings its material. Pure;
// any thread.
std::vector<KnowledgeHit> search_knowledge(std::string_view query, std::size_t count);

// The materials that are most like one, itself left out: nearest in the logarithms of density and modulus, of
// the same class and as fragile first. `count` of them, or all others.
std::vector<const MaterialRow*> similar_materials(const MaterialRow& material, std::size_t count);

// The row with this id, or the one whose bare name it is (materials first).
KnowledgeHit find_knowledge(std::string_view id);  // no pointer where there is none

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/knowledge/tables.h"

namespace livegs {

// A row of either table, for example "material:stoneware" or "object:mug". One of the pointers is null.
struct KnowledgeHit {
  std::string id;
  const MaterialRow* material = nullptr;
  const ObjectRow* object = nullptr;
  double score = 0;
};

// Searches both tables; returns at most `count` rows, best first, and none if nothing matches.
//
// The score is the sum of three terms:
// - BM25 over the words of names, classes and aliases (Robertson & Zaragoza 2009);
// - the fraction of common character trigrams, for misspelt and joined words;
// - the aliases of the tables; an object also scores its material.
// Pure; any thread.
std::vector<KnowledgeHit> search_knowledge(std::string_view query, std::size_t count);

// Returns the materials most similar to one, excluding itself: nearest in log density and log modulus, with
// the same class and fragility first. Returns `count` of them, or all others if fewer.
std::vector<const MaterialRow*> similar_materials(const MaterialRow& material, std::size_t count);

// Finds the row with this id, or with this bare name (materials first).
KnowledgeHit find_knowledge(std::string_view id);  // both pointers null if not found

}  // namespace livegs

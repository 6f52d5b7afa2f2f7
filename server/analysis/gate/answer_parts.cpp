// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/answer_parts.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/text/format_text.h"
#include "core/text/lower_case.h"

namespace livegs {
namespace {

// Adds the share, boxes and votes of `other`. A part without boxes has all that the others leave, so it stays
// without them, unless the two are one part.
void add_part(AnswerPart& part, const AnswerPart& other, bool one_part) {
  part.share += other.share;
  if (one_part && !part.thickness_m) part.thickness_m = other.thickness_m;
  if (one_part || !part.boxes.empty())
    part.boxes.insert(part.boxes.end(), other.boxes.begin(), other.boxes.end());
  part.votes.resize(std::max(part.votes.size(), other.votes.size()), 0.0f);
  for (size_t i = 0; i < other.votes.size(); ++i) part.votes[i] += other.votes[i];
}

}  // namespace

void join_equal_parts(std::vector<AnswerPart>& parts, std::vector<std::string>& changes) {
  std::vector<AnswerPart> kept;
  std::map<std::tuple<std::string, const MaterialRow*, std::string>, size_t> index;
  std::string joined, renamed;
  const auto note = [](std::string& names, const std::string& name) {
    if (("," + names + ",").find(", " + name + ",") == std::string::npos) names += ", " + name;
  };
  for (AnswerPart& part : parts) {
    if (part.name.empty()) part.name = part.material->name;
    const auto [at, fresh] =
        index.try_emplace({lower_case(part.name), part.material, lower_case(part.inside)}, kept.size());
    if (fresh) {
      kept.push_back(std::move(part));
      continue;
    }
    add_part(kept[at->second], part, true);
    note(joined, kept[at->second].name);
  }
  std::map<std::string, size_t> count;  // of parts with this name so far
  for (const AnswerPart& part : kept) count.try_emplace(lower_case(part.name), 0);
  for (AnswerPart& part : kept) {
    const std::string name = part.name;
    size_t& number = count[lower_case(name)];
    if (++number == 1) continue;
    note(renamed, name);
    const auto taken = [&] {
      return std::any_of(kept.begin(), kept.end(), [&](const AnswerPart& other) {
        return &other != &part && lower_case(other.name) == lower_case(part.name);
      });
    };
    for (part.name = name + " " + std::to_string(number); taken();)
      part.name = name + " " + std::to_string(++number);
  }
  if (!joined.empty())
    changes.push_back("parts: those of one name and material were joined: " + joined.substr(2));
  if (!renamed.empty()) changes.push_back("parts: equal names got numbers: " + renamed.substr(2));
  parts = std::move(kept);
}

void limit_parts(std::vector<AnswerPart>& parts, size_t most, std::vector<std::string>& changes) {
  if (parts.size() <= most) return;
  const auto first_surplus = parts.begin() + static_cast<std::ptrdiff_t>(most);
  std::map<std::string, std::string> holder;  // of parts that are gone, by their names in lower case
  for (auto part = first_surplus; part != parts.end(); ++part) {
    auto into = std::find_if(parts.begin(), first_surplus,
                             [&](const AnswerPart& other) { return other.material == part->material; });
    if (into == first_surplus) into = parts.begin();
    add_part(*into, *part, false);
    holder.emplace(lower_case(part->name), into->name);
  }
  changes.push_back(format_text("parts: %zu are given; the %zu smallest were added to the larger ones",
                                parts.size(), parts.size() - most));
  parts.erase(first_surplus, parts.end());
  for (AnswerPart& part : parts) {
    if (part.inside.empty()) continue;
    if (const auto gone = holder.find(lower_case(part.inside)); gone != holder.end())
      part.inside = gone->second == part.name ? "" : gone->second;
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const AnswerPart& a, const AnswerPart& b) { return a.share > b.share; });
}

}  // namespace livegs

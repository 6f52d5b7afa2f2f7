// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <map>

#include "analysis/gate/gate.h"
#include "analysis/knowledge/name_match.h"
#include "core/assert.h"
#include "core/percentile.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

double log_median(std::vector<double> values) {
  for (double& value : values) value = std::log(value);
  return std::exp(median(std::move(values)));
}

template <class Value>
std::vector<Value> each(std::span<const Answer> answers, std::optional<Value> Answer::*member) {
  std::vector<Value> found;
  for (const Answer& answer : answers) {
    if (answer.*member) found.push_back(*(answer.*member));
  }
  return found;
}

// Median of the best values; the range covers all best values and the median low and high.
Span3 span_median(const std::vector<Span3>& spans) {
  std::vector<double> low, best, high;
  for (const Span3& span : spans) {
    low.push_back(span.low);
    best.push_back(span.best);
    high.push_back(span.high);
  }
  return {std::min(log_median(low), *std::min_element(best.begin(), best.end())), log_median(best),
          std::max(log_median(high), *std::max_element(best.begin(), best.end()))};
}

// The most frequent value; ties to the first.
template <class Key, class Of>
size_t majority(std::span<const Answer> answers, Of of) {
  size_t first = 0, most = 0;
  for (size_t i = 0; i < answers.size(); ++i) {
    const Key key = of(answers[i]);
    const auto votes = static_cast<size_t>(
        std::count_if(answers.begin(), answers.end(), [&](const Answer& one) { return of(one) == key; }));
    if (votes > most) {
      most = votes;
      first = i;
    }
  }
  return first;
}

// The alternatives of several answers: those of one name are one, with the mean of their probabilities. An
// answer without alternatives counts as one that is certain.
std::vector<MassAlternative> pooled(std::span<const Answer> answers) {
  std::vector<std::pair<MassAlternative, std::vector<Span3>>> groups;
  for (const Answer& answer : answers) {
    std::vector<MassAlternative> own = answer.alternatives;
    if (own.empty()) own.push_back({answer.name, 1, answer.mass_kg});
    for (const MassAlternative& one : own) {
      auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& known) {
        return normalised_name(known.first.name) == normalised_name(one.name);
      });
      if (group == groups.end()) group = groups.insert(groups.end(), {{one.name, 0, {}}, {}});
      group->first.probability += one.probability / static_cast<double>(answers.size());
      group->second.push_back(one.mass_kg);
    }
  }
  std::vector<MassAlternative> result;
  for (auto& [one, masses] : groups) {
    one.mass_kg = span_median(masses);
    result.push_back(std::move(one));
  }
  std::stable_sort(result.begin(), result.end(), [](const MassAlternative& a, const MassAlternative& b) {
    return a.probability > b.probability;
  });
  return result;
}

// Adds the votes of all answers about the parts of `result`: the same material, and the same name if that
// occurs twice.
void pool_part_votes(std::span<const Answer> answers, Answer& result) {
  for (AnswerPart& part : result.parts) {
    std::vector<float> sum;
    for (const Answer& answer : answers) {
      const AnswerPart* same = nullptr;
      for (const AnswerPart& other : answer.parts) {
        if (other.material != part.material) continue;
        if (!same || normalised_name(other.name) == normalised_name(part.name)) same = &other;
      }
      if (!same || same->votes.empty()) continue;
      sum.resize(same->votes.size(), 0.0f);
      for (size_t i = 0; i < sum.size(); ++i) sum[i] += same->votes[i];
    }
    part.votes = std::move(sum);
  }
}

}  // namespace

Answer vote(std::span<const Answer> answers) {
  LIVEGS_ASSERT(!answers.empty());
  if (answers.size() == 1) return answers.front();
  // Parts, fill, behaviour and fragility are one judgement and are taken from one answer.
  const size_t chosen = majority<std::string>(answers, [](const Answer& one) {
    return one.parts.front().material->name + "/" + std::to_string(one.behavior) + std::to_string(one.fill) +
           (one.fragile ? "!" : "");
  });
  Answer result = answers[chosen];
  std::vector<Span3> masses;
  for (const Answer& answer : answers) masses.push_back(answer.mass_kg);
  result.mass_kg = span_median(masses);
  if (std::any_of(answers.begin(), answers.end(),
                  [](const Answer& one) { return !one.alternatives.empty(); })) {
    std::vector<MassAlternative> alternatives = pooled(answers);
    // The mass is that of the most likely thing, so name, parts, fill, behaviour and fragility are too.
    const std::string likely = normalised_name(alternatives.front().name);
    const auto same = [&](const Answer& one) { return normalised_name(one.name) == likely; };
    const auto source = std::find_if(answers.begin(), answers.end(), same);
    if (!same(result) && source != answers.end()) result = *source;
    result.name = alternatives.front().name;
    result.mass_kg = alternatives.front().mass_kg;
    result.alternatives = std::move(alternatives);
  }
  // A median of the moduli of different materials is meaningless; only answers with the chosen material
  // count.
  std::vector<Span3> young, structure;
  for (const Answer& answer : answers) {
    if (answer.parts.front().material != result.parts.front().material || answer.behavior != result.behavior)
      continue;
    if (answer.youngs_modulus_pa) young.push_back(*answer.youngs_modulus_pa);
    if (answer.structure_coefficient) structure.push_back(*answer.structure_coefficient);
  }
  if (!young.empty()) result.youngs_modulus_pa = span_median(young);
  if (!structure.empty()) result.structure_coefficient = span_median(structure);
  const auto numbers = [&](std::optional<double> Answer::*member) {
    const std::vector<double> found = each(answers, member);
    if (!found.empty()) result.*member = median(found);
  };
  numbers(&Answer::plasticity);
  numbers(&Answer::friction);
  numbers(&Answer::restitution);
  std::vector<double> confidences;
  for (const Answer& answer : answers) confidences.push_back(answer.confidence);
  result.confidence = median(confidences);
  const auto [least, most] = std::minmax_element(
      masses.begin(), masses.end(), [](const Span3& a, const Span3& b) { return a.best < b.best; });
  result.changes.push_back(format_text("%zu views; mass_g from %.4g to %.4g, median %.4g", answers.size(),
                                       least->best * 1e3, most->best * 1e3, result.mass_kg.best * 1e3));
  pool_part_votes(answers, result);
  return result;
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/model/prompt_trial.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace livegs {
namespace {

constexpr int kResamplings = 2000;

struct Measure {
  const char* name;
  double better;  // the sign of an improvement
  bool may_help;  // false if the measure can only count against a set
  double (*of)(const PromptOutcome&);
};
constexpr Measure kMeasures[] = {
    {"mape", -1, true,
     [](const PromptOutcome& o) { return std::abs(o.mass.best_kg - o.mass.true_kg) / o.mass.true_kg; }},
    {"alde", -1, true,
     [](const PromptOutcome& o) { return std::abs(std::log(o.mass.best_kg / o.mass.true_kg)); }},
    {"mnre", 1, true,
     [](const PromptOutcome& o) {
       return std::min(o.mass.best_kg / o.mass.true_kg, o.mass.true_kg / o.mass.best_kg);
     }},
    {"coverage", 1, false,
     [](const PromptOutcome& o) {
       return o.mass.low_kg <= o.mass.true_kg && o.mass.true_kg <= o.mass.high_kg ? 1.0 : 0.0;
     }},
    {"behaviour_right", 1, true, [](const PromptOutcome& o) { return o.behaves ? 1.0 : 0.0; }},
    {"refused", -1, true, [](const PromptOutcome& o) { return o.refused ? 1.0 : 0.0; }},
    {"for_review", -1, true, [](const PromptOutcome& o) { return o.review ? 1.0 : 0.0; }},
    {"repaired", -1, true, [](const PromptOutcome& o) { return o.repaired ? 1.0 : 0.0; }},
};

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

Figure mean_with_interval(const std::vector<double>& values) {
  std::mt19937_64 random(1);
  std::vector<double> means;
  for (int i = 0; i < kResamplings; ++i) {
    double sum = 0;
    for (size_t k = 0; k < values.size(); ++k) sum += values[random() % values.size()];
    means.push_back(sum / static_cast<double>(values.size()));
  }
  std::sort(means.begin(), means.end());
  return {mean(values), means[kResamplings / 40], means[kResamplings - 1 - kResamplings / 40]};
}

PromptOutcome outcome_of(const JudgedObject& object, const AnalysisUpdate& update) {
  PromptOutcome outcome;
  const v1::EstimatedValue& mass = update.parameters.mass_kg();
  outcome.mass = {object.id, object.mass_kg, mass.low(), mass.best(), mass.high()};
  outcome.behaves = update.parameters.behavior() == object.behavior;
  outcome.review = update.judgement.verdict == Verdict::NeedsReview;
  outcome.refused = update.judgement.verdict == Verdict::Refused;
  outcome.repaired = update.turns.size() > 1;
  return outcome;
}

}  // namespace

Result<PromptTrial> try_prompts(std::span<const JudgedObject> objects, ModelEndpoint& endpoint,
                                const TargetViews& views) {
  PromptTrial trial;
  trial.prompt_version = endpoint.state().prompt_version;
  for (const JudgedObject& object : objects) {
    AnalysisUpdate last;
    analyze_scene(std::span(&object.target, 1), &endpoint, views, {},
                  [&](const AnalysisUpdate& update) { last = update; });
    if (last.turns.empty()) return Error{ErrorCode::Unavailable, object.id + ": " + last.judgement.message};
    trial.model = last.turns.back().answer.model;
    trial.prompt_tokens += last.record.prompt_tokens();
    trial.completion_tokens += last.record.completion_tokens();
    trial.cost_usd += last.record.cost_usd();
    trial.outcomes.push_back(outcome_of(object, last));
  }
  return trial;
}

const char* verdict_name(PromptVerdict verdict) {
  return verdict == PromptVerdict::Better ? "better" : verdict == PromptVerdict::Worse ? "worse" : "same";
}

PromptComparison compare_prompts(const PromptTrial& before, const PromptTrial& after) {
  PromptComparison comparison;
  bool helped = false, harmed = false;
  for (const Measure& measure : kMeasures) {
    std::vector<double> first, second, change;
    for (size_t i = 0; i < before.outcomes.size(); ++i) {
      first.push_back(measure.of(before.outcomes[i]));
      second.push_back(measure.of(after.outcomes[i]));
      change.push_back(second.back() - first.back());
    }
    PromptMeasure row{measure.name, mean(first), mean(second), mean_with_interval(change)};
    const double worst = measure.better > 0 ? row.change.low : -row.change.high;
    const double best = measure.better > 0 ? row.change.high : -row.change.low;
    if (worst > 0) row.verdict = PromptVerdict::Better;
    if (best < 0) row.verdict = PromptVerdict::Worse;
    helped |= row.verdict == PromptVerdict::Better && measure.may_help;
    harmed |= row.verdict == PromptVerdict::Worse;
    comparison.measures.push_back(row);
  }
  comparison.verdict = harmed ? PromptVerdict::Worse : helped ? PromptVerdict::Better : PromptVerdict::Same;
  return comparison;
}

}  // namespace livegs

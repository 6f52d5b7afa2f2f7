// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/analyze_scene.h"
#include "server/analysis/estimate/mass_scores.h"

// Comparison of two prompt sets by their results for objects of known mass and behaviour.

namespace livegs {

struct JudgedObject {
  std::string id;
  AnalysisTarget target;
  double mass_kg = 0;  // true mass
  v1::Physics::Behavior behavior = v1::Physics::RIGID;
};

// Final values of one object; the offline estimate if the answer was not accepted.
struct PromptOutcome {
  MassAnswer mass;
  bool behaves = false;   // the behaviour is correct
  bool refused = false;   // by the gate, also after a repair
  bool review = false;    // too far from the estimate: a proposal
  bool repaired = false;  // needed a repair
};

struct PromptTrial {
  std::string prompt_version, model;  // as in RawAnswer
  std::vector<PromptOutcome> outcomes;
  std::int64_t prompt_tokens = 0, completion_tokens = 0;
  double cost_usd = 0;  // 0 if unknown
};

// Queries the objects one after the other, each alone. Fails at the first object without an answer and names
// its id, because measures of a part are not comparable. Blocks.
Result<PromptTrial> try_prompts(std::span<const JudgedObject> objects, ModelEndpoint& endpoint,
                                const TargetViews& views);

enum class PromptVerdict { Better, Same, Worse };
const char* verdict_name(PromptVerdict verdict);  // "better", "same", "worse"

// Means over the objects with either set, and the mean paired change with its 95 % bootstrap interval over
// objects (2000 resamplings, a fixed seed).
struct PromptMeasure {
  const char* name;
  double before = 0, after = 0;
  Figure change;
  PromptVerdict verdict = PromptVerdict::Same;  // Better or Worse only if the interval excludes 0
};

struct PromptComparison {
  std::vector<PromptMeasure> measures;
  // Worse if any measure is worse, else Better if any is better. Coverage can only count as worse: a wider
  // range is not a better answer.
  PromptVerdict verdict = PromptVerdict::Same;
};

// Precondition: the same objects in the same order, at least one.
PromptComparison compare_prompts(const PromptTrial& before, const PromptTrial& after);

}  // namespace livegs

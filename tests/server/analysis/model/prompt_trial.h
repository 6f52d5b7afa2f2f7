// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/analyze_scene.h"
#include "server/analysis/estimate/mass_scores.h"

// Which of two sets of prompts is better, by what comes of them for things whose truth is known.

namespace livegs {

struct JudgedObject {
  std::string id;
  AnalysisTarget target;
  double mass_kg = 0;  // the true one
  v1::Physics::Behavior behavior = v1::Physics::RIGID;
};

// What one object had in the end, with the offline estimate where the answer was not taken.
struct PromptOutcome {
  MassAnswer mass;
  bool behaves = false;   // as the thing does
  bool refused = false;   // by the gate, also after it was told why
  bool review = false;    // too far from the estimate: kept as a proposal
  bool repaired = false;  // it had to be told once
};

struct PromptTrial {
  std::string prompt_version, model;  // as in RawAnswer
  std::vector<PromptOutcome> outcomes;
  std::int64_t prompt_tokens = 0, completion_tokens = 0;
  double cost_usd = 0;  // 0: unknown
};

// Asks about one object after the other, each alone. Fails on the first that could not be asked, with its id:
// figures of a part would say nothing. Blocks.
Result<PromptTrial> try_prompts(std::span<const JudgedObject> objects, ModelEndpoint& endpoint,
                                const TargetViews& views);

enum class PromptVerdict { Better, Same, Worse };
const char* verdict_name(PromptVerdict verdict);  // "better", "same", "worse"

// A mean over the objects with the one set and with the other, and the change from object to object with the
// 95 % interval of a bootstrap over objects (2000 resamplings, a fixed seed).
struct PromptMeasure {
  const char* name;
  double before = 0, after = 0;
  Figure change;
  PromptVerdict verdict = PromptVerdict::Same;  // better or worse only where the interval leaves 0 out
};

struct PromptComparison {
  std::vector<PromptMeasure> measures;
  // Worse if any measure is; else better if any is. Coverage may only do harm: a wider range is no better
  // answer.
  PromptVerdict verdict = PromptVerdict::Same;
};

// Precondition: the same objects in the same order, at least one.
PromptComparison compare_prompts(const PromptTrial& before, const PromptTrial& after);

}  // namespace livegs

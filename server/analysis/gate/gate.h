// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/gate/answer.h"

// The acceptance gate: nothing a language model says reaches an object but through here. An answer is read
// (analysis/answer.h: parse, schema, order, hard ranges), examined (units, physics, consistency) and held
// against what was known before (prior: gate_prior.h, fusion). The deformation resistance is computed here
// from E* = s E, never taken from the answer.

namespace livegs {

enum class Verdict {
  Accepted,
  NeedsReview,  // possible, but far from what was known or at odds with itself: kept as a proposal, the
                // object keeps its values
  Refused,
};

struct Judgement {
  Verdict verdict = Verdict::Refused;
  // What the object shall have: fused when accepted, else what it had before. Values of source SCENE or
  // PERSON are never changed.
  v1::PhysicalParameters parameters;
  // What the answer comes to, fused or not; empty when refused.
  v1::PhysicalParameters proposal;
  std::vector<std::string>
      changes;  // all that was read, mended or weighed otherwise than it stands in the answer
  std::vector<std::string>
      remarks;  // what else the answer says, a line each: its name for the object, its size, its sources
  std::string message;  // refused: what is wrong, one line, fit for a repair turn; needs review: why
};

// Steps 5 to 7: units, physics, consistency. Mends and notes what it can; the error is one line for a repair
// turn, of prompts/complaints.json.
Result<Answer> validate_answer(Answer answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                               const MessageTemplates& words = MessageTemplates::built_in());

// Steps 8 and 9: prior and fusion by inverse variance in log space. `offline` is what the object has now.
Judgement weigh_answer(const Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline);

// One answer from several about the same object (views): medians, of logarithms for mass, Young's modulus and
// s; the majority for the rest, the first of equals. The range of the mass covers what the answers disagree
// by. Precondition: at least one, each examined.
Answer vote(std::span<const Answer> answers);

}  // namespace livegs

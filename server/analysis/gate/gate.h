// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/gate/answer.h"

// Acceptance gate: every answer of a language model passes it before it reaches an object.
//
// An answer is read (answer.h: parse, schema, order, hard ranges), validated (units, physics, consistency)
// and compared with the prior estimate (prior_check.h), then fused with it. The deformation resistance is
// computed here from E* = s E, never taken from the answer.

namespace livegs {

enum class Verdict {
  Accepted,
  NeedsReview,  // possible, but far from the prior or inconsistent: kept as a proposal; the object is
                // unchanged
  Refused,
};

struct Judgement {
  Verdict verdict = Verdict::Refused;
  // Resulting values of the object: fused if accepted, else unchanged. Values of source SCENE or PERSON are
  // never changed.
  v1::PhysicalParameters parameters;
  // Values of the answer, fused or not; empty if refused.
  v1::PhysicalParameters proposal;
  std::vector<std::string> changes;  // values interpreted, corrected or reweighted, one line each
  // Other statements of the answer, one line each: object name, size, sources.
  std::vector<std::string> remarks;
  std::string message;  // refused: the fault, one line, suitable for a repair turn; needs review: the reason
};

// Steps 5 to 7: units, physics, consistency. Corrects and notes recoverable faults. The error is one line of
// prompts/complaints.json for a repair turn.
Result<Answer> validate_answer(Answer answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                               const MessageTemplates& words = MessageTemplates::built_in());

// Steps 8 and 9: prior and fusion by inverse variance in log space. `offline` holds the current values of the
// object.
Judgement weigh_answer(const Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline);

// Combines several answers about the same object (views). Medians, of logarithms for mass, Young's modulus
// and s; the majority for other fields, ties to the first. The mass range covers the spread of the answers.
// Precondition: at least one answer, each validated.
Answer vote(std::span<const Answer> answers);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/gate/answer.h"

// Acceptance gate: an answer of a language model must pass this gate before its values reach an object. The
// steps, in the order in which they run:
//
//   1 answer_object    answer_object.cpp    one JSON object; size, UTF-8, depth       refuse
//   2 read_answer      read_answer.cpp      types, words, low <= best <= high, hard   refuse
//                                           ranges (value_ranges.h)
//   3 mend_units       validate_answer.cpp  mass or modulus in another unit           correct
//   4 check_physics    validate_answer.cpp  mass against volume                       refuse
//   5 make_consistent  validate_answer.cpp  modulus, behaviour, fragility             refuse or correct
//   6 vote             vote.cpp             answers of several views                  combine
//   7 fuse_answer      fuse_answer.cpp      fusion with the tables; friction,         clamp
//                                           restitution, plasticity; hard ranges
//   8 check_prior      prior_check.cpp      likelihood under the tables, mass bounds  hold for review
//
// read_answer() runs steps 1 and 2, validate_answer() 3 to 5, weigh_answer() 7 and 8; ask_model()
// (run/ask_model.cpp) calls them. After a refusal it sends the fault to the model once, as a repair turn. A
// second refusal drops the answer; without any answer the object keeps its offline estimate.
//
// The deformation resistance is computed in step 7 from E* = s E, never taken from the answer.

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

// Steps 3 to 5: units, physics, consistency. Corrects and notes recoverable faults. The error is one line of
// prompts/complaints.json for a repair turn.
Result<Answer> validate_answer(Answer answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                               const MessageTemplates& words = MessageTemplates::built_in());

// Step 6: combines several answers about the same object (views). Medians, of logarithms for mass, Young's
// modulus and s; the majority for other fields, ties to the first. The mass range covers the spread of the
// answers. Precondition: at least one answer, each validated.
Answer vote(std::span<const Answer> answers);

// Steps 7 and 8: fusion by inverse variance in log space, then the prior check. `offline` holds the current
// values of the object.
Judgement weigh_answer(const Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/gate.h"

#include <cmath>

#include "analysis/gate/fuse_answer.h"
#include "analysis/gate/prior_check.h"
#include "core/text/format_text.h"

// Steps 7 and 8 of the gate: fuse_answer() (fuse_answer.cpp), then check_prior() (prior_check.cpp), which
// accepts the values or holds them for review.

namespace livegs {
namespace {

// Uncertainty factor of a guessed scale.
constexpr double kMaxSizeRatio = 2.0;

// Other statements of the answer, for the reader of the record; they affect no value.
std::vector<std::string> remarks_of(const Answer& answer, const ObjectFacts& facts) {
  std::vector<std::string> remarks;
  std::string name = "the object was identified as \"" + answer.name + "\"";
  if (answer.name_confidence) name += format_text(", with confidence %.2g", *answer.name_confidence);
  if (answer.replica) name += *answer.replica ? ", a toy or an imitation" : ", a real one";
  remarks.push_back(std::move(name));
  const double stands_m = facts.mesh.size_m.maxCoeff();
  if (answer.longest_side_m && stands_m > 0) {
    std::string size =
        format_text("assumed length %.3g m; length in the scene %.3g m", *answer.longest_side_m, stands_m);
    if (std::abs(std::log(*answer.longest_side_m / stands_m)) > std::log(kMaxSizeRatio)) {
      size += facts.scale_known ? ", which is measured"
                                : ", which is a guess; if the model is right, set the scale of the object";
    }
    remarks.push_back(std::move(size));
  }
  if (!answer.kb_ids.empty()) {
    std::string rows;
    for (const std::string& id : answer.kb_ids) rows += (rows.empty() ? "" : ", ") + id;
    remarks.push_back("it went by " + rows);
  }
  return remarks;
}

}  // namespace

Judgement weigh_answer(const Answer& answer, const ObjectFacts& facts,
                       const v1::PhysicalParameters& offline) {
  Judgement judgement;
  judgement.changes = answer.changes;
  judgement.remarks = remarks_of(answer, facts);
  judgement.proposal = fuse_answer(answer, facts, offline, judgement.changes);
  judgement.message = check_prior(answer, facts, offline, judgement.proposal);
  judgement.verdict = judgement.message.empty() ? Verdict::Accepted : Verdict::NeedsReview;
  judgement.parameters = judgement.message.empty() ? judgement.proposal : offline;
  return judgement;
}

}  // namespace livegs

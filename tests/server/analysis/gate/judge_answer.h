// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "analysis/gate/gate.h"
#include "server/analysis/gate/answer_fixtures.h"

namespace livegs {

// Runs one answer through the whole gate, in the steps of ask_model: read, validate, vote (of one), weigh.
// `offline` holds the current values of the object.
inline Judgement judge_answer(std::string_view raw, const ObjectFacts& facts,
                              const v1::PhysicalParameters& offline) {
  auto answer = read_answer(raw);
  if (answer) answer = validate_answer(std::move(*answer), facts, offline);
  if (answer) return weigh_answer(vote(std::span(&*answer, 1)), facts, offline);
  Judgement refused;
  refused.parameters = offline;
  refused.message = answer.error().message;
  return refused;
}

// For an object without user or scene values.
inline Judgement judge(const nlohmann::json& answer, const ObjectFacts& facts = mug_facts()) {
  return judge_answer(answer.dump(), facts, estimate_offline(facts));
}

inline bool same(const google::protobuf::Message& a, const google::protobuf::Message& b) {
  return a.SerializeAsString() == b.SerializeAsString();
}

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "analysis/gate.h"

namespace livegs {

// One answer through the whole gate, by the steps that ask_model takes: read, examine, vote (of one), weigh.
// `offline` is what the object has now.
inline Judgement judge_answer(std::string_view raw, const ObjectFacts& facts,
                              const v1::PhysicalParameters& offline) {
  auto answer = read_answer(raw);
  if (answer) answer = examine_answer(std::move(*answer), facts, offline);
  if (answer) return weigh_answer(vote(std::span(&*answer, 1)), facts, offline);
  Judgement refused;
  refused.parameters = offline;
  refused.message = answer.error().message;
  return refused;
}

}  // namespace livegs

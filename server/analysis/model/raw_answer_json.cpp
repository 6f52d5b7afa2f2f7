// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/raw_answer_json.h"

#include <cstdint>

namespace livegs {
namespace {

constexpr double kMaxTokens = 1e15;  // exact in a double and in an int64_t

std::int64_t tokens_of(const Json& json, const char* key) {
  const double value = number_member(json, key).value_or(0);
  return value > 0 && value < kMaxTokens ? static_cast<std::int64_t>(value) : 0;
}

}  // namespace

OrderedJson raw_answer_json(const RawAnswer& answer) {
  OrderedJson json = {{"json", answer.json},
                      {"model", answer.model},
                      {"prompt_version", answer.prompt_version},
                      {"prompt_tokens", answer.prompt_tokens},
                      {"completion_tokens", answer.completion_tokens},
                      {"cost_usd", answer.cost_usd},
                      {"wall_s", answer.wall_s},
                      {"transcript", answer.transcript},
                      {"warnings", answer.warnings}};
  if (answer.blind) json["blind"] = true;
  return json;
}

std::optional<RawAnswer> read_raw_answer(const Json& json) {
  RawAnswer answer;
  answer.json = text_member(json, "json");
  if (answer.json.empty()) return std::nullopt;
  answer.model = text_member(json, "model");
  answer.prompt_version = text_member(json, "prompt_version");
  answer.prompt_tokens = tokens_of(json, "prompt_tokens");
  answer.completion_tokens = tokens_of(json, "completion_tokens");
  answer.cost_usd = number_member(json, "cost_usd").value_or(0);
  answer.wall_s = number_member(json, "wall_s").value_or(0);
  answer.transcript = text_member(json, "transcript");
  if (const Json* blind = member(json, "blind")) answer.blind = *blind == true;
  if (const Json* warnings = member(json, "warnings"); warnings && warnings->is_array()) {
    for (const Json& warning : *warnings) {
      if (warning.is_string()) answer.warnings.push_back(warning.get<std::string>());
    }
  }
  return answer;
}

}  // namespace livegs

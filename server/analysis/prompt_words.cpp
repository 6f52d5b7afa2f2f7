// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/prompt_words.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/prompt_text.h"
#include "complaints.json.h"
#include "core/assert.h"
#include "facts.json.h"
#include "tool_words.json.h"

namespace livegs {
namespace {

constexpr const char* kBuiltIn[] = {kFactsPrompt, kComplaintsPrompt, kToolWordsPrompt};  // in the order of kFiles

}  // namespace

Result<PromptWords> PromptWords::read(const std::map<std::string, std::string>& texts) {
  PromptWords words;
  for (size_t i = 0; i < std::size(kFiles); ++i) {
    const std::string file = kFiles[i];
    const auto given = texts.find(file);
    const auto own = nlohmann::json::parse(kBuiltIn[i], nullptr, false);
    const auto json = given == texts.end() ? own : nlohmann::json::parse(given->second, nullptr, false);
    if (!json.is_object()) return invalid_data("prompts/" + file + ": not a JSON object");
    for (const auto& [name, text] : json.items()) {
      if (!text.is_string()) return invalid_data("prompts/" + file + ": " + name + " is no text");
      if (!own.contains(name)) return invalid_data("prompts/" + file + ": " + name + " is no line that is ever said");
      if (!words.lines_.emplace(name, text.get<std::string>()).second)
        return invalid_data("prompts/" + file + ": " + name + " stands in another file already");
    }
    for (const auto& [name, text] : own.items()) {
      if (!json.contains(name)) return invalid_data("prompts/" + file + ": has no line " + name);
    }
  }
  return words;
}

const PromptWords& PromptWords::built_in() {
  static const PromptWords words = [] {
    auto read = PromptWords::read({});
    LIVEGS_ASSERT(read);  // a test reads them
    return std::move(*read);
  }();
  return words;
}

std::string PromptWords::say(std::string_view line,
                             std::initializer_list<std::pair<std::string_view, std::string_view>> slots) const {
  const auto found = lines_.find(line);
  if (found == lines_.end()) return std::string(line);
  return fill_line(found->second, [&](std::string_view slot) {
    const auto told = std::find_if(slots.begin(), slots.end(), [&](const auto& one) { return one.first == slot; });
    return told == slots.end() ? std::string() : std::string(told->second);
  });
}

}  // namespace livegs

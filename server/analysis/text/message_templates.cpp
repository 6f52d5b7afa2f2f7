// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/text/message_templates.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/text/prompt_slots.h"
#include "analysis/text/prompt_text.h"
#include "complaints.json.h"
#include "core/assert.h"
#include "facts.json.h"
#include "mass_reasons.json.h"
#include "tool_words.json.h"

namespace livegs {
namespace {

constexpr const char* kBuiltInTemplates[] = {kFactsPrompt, kComplaintsPrompt,
                                             kToolWordsPrompt};  // in the order of kFiles

}  // namespace

Result<MessageTemplates> MessageTemplates::read(const std::map<std::string, std::string>& texts,
                                                const std::filesystem::path& folder) {
  MessageTemplates words;
  for (size_t i = 0; i < std::size(kFiles); ++i) {
    const std::string path = (folder / kFiles[i]).string() + ": ";
    const auto given = texts.find(kFiles[i]);
    const auto own = nlohmann::json::parse(kBuiltInTemplates[i], nullptr, false);
    const auto json = given == texts.end() ? own : nlohmann::json::parse(given->second, nullptr, false);
    if (!json.is_object())
      return invalid_data(path + "not a JSON object; correct it, or delete the file to use the built-in one");
    for (const auto& [name, text] : json.items()) {
      if (!text.is_string()) return invalid_data(path + name + " is not a string; write its text in quotes");
      if (!own.contains(name)) return invalid_data(path + name + " is not a line of this file; remove it");
      if (!words.lines_.emplace(name, text.get<std::string>()).second)
        return invalid_data(path + name + " is already defined in another file; remove it");
      const SlotNames known = slots_of(own[name].get<std::string>());
      if (auto checked = check_slots(text.get<std::string>(), known); !checked)
        return invalid_data(path + name + ", " + checked.error().message);
    }
    for (const auto& [name, text] : own.items()) {
      if (!json.contains(name))
        return invalid_data(path + "has no line " + name +
                            "; add it, or delete the file to use the built-in one");
    }
  }
  return words;
}

const MessageTemplates& MessageTemplates::built_in() {
  static const MessageTemplates words = [] {
    auto read = MessageTemplates::read({});
    LIVEGS_ASSERT(read);  // a test reads them
    return std::move(*read);
  }();
  return words;
}

const MessageTemplates& MessageTemplates::reasons() {
  static const MessageTemplates words = [] {
    MessageTemplates read;
    const auto json = nlohmann::json::parse(kMassReasons, nullptr, false);
    for (const auto& [name, text] : json.items()) read.lines_.emplace(name, text.get<std::string>());
    return read;
  }();
  return words;
}

std::string MessageTemplates::say(
    std::string_view line, std::initializer_list<std::pair<std::string_view, std::string_view>> slots) const {
  const auto found = lines_.find(line);
  if (found == lines_.end()) return std::string(line);
  return fill_line(found->second, [&](std::string_view slot) {
    const auto value =
        std::find_if(slots.begin(), slots.end(), [&](const auto& one) { return one.first == slot; });
    return value == slots.end() ? std::string() : std::string(value->second);
  });
}

}  // namespace livegs

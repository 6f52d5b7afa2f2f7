// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "core/result.h"

namespace livegs {

// Text lines of prompts/ with slots for values, by their names: facts of an object (facts.json), faults of an
// answer (complaints.json) and texts of tool results (tool_words.json).
// Immutable; any thread.
class MessageTemplates {
 public:
  static constexpr const char* kFiles[] = {"facts.json", "complaints.json", "tool_words.json"};

  static const MessageTemplates& built_in();
  // Reads the lines from `texts`, keyed by the names of kFiles; a missing file is replaced by the compiled-in
  // one. Fails if a text is not an object of strings, if a file lacks a line or has an extra one, or if a
  // line has an unknown slot. The error begins with the path of the file in `folder`.
  static Result<MessageTemplates> read(const std::map<std::string, std::string>& texts,
                                       const std::filesystem::path& folder = "prompts");
  // Texts of the origin of a mass estimate (mass_reasons.json), for users and for the line of the offline
  // estimate. They are written into sidecars and therefore not replaced by a prompt folder.
  static const MessageTemplates& reasons();

  // Returns the line with its {{slots}} filled in one pass; inserted values are not scanned again. An unknown
  // name is returned unchanged; a test detects it.
  std::string say(std::string_view line,
                  std::initializer_list<std::pair<std::string_view, std::string_view>> slots = {}) const;

  const std::map<std::string, std::string, std::less<>>& lines() const { return lines_; }

 private:
  std::map<std::string, std::string, std::less<>> lines_;
};

}  // namespace livegs

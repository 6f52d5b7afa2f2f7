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

// The lines of prompts/ that are put together from figures, by their names in these files: what is told of an
// object (facts.json), what is wrong with an answer (complaints.json), what tools say beside numbers
// (tool_words.json). Immutable; any thread.
class MessageTemplates {
 public:
  static constexpr const char* kFiles[] = {"facts.json", "complaints.json", "tool_words.json"};

  static const MessageTemplates& built_in();
  // `texts` by the names of kFiles; a file that is not given is the one that is compiled in. Fails on what is
  // no object of texts, on a file that lacks a line of its own or has one more, and on a slot that the line
  // does not have; the message begins with the file's path in `folder`.
  static Result<MessageTemplates> read(const std::map<std::string, std::string>& texts,
                                       const std::filesystem::path& folder = "prompts");
  // Not of prompts/: how an estimate says where a mass comes from (mass_reasons.json), which a person reads
  // and the line of an offline estimate takes along. It is written into sidecars, so no folder of prompts
  // takes its place.
  static const MessageTemplates& reasons();

  // The line with its {{slots}} filled, in one pass: what they are filled with is not looked at again. A name
  // that is in no file gives itself: a test finds it.
  std::string say(std::string_view line,
                  std::initializer_list<std::pair<std::string_view, std::string_view>> slots = {}) const;

  const std::map<std::string, std::string, std::less<>>& lines() const { return lines_; }

 private:
  std::map<std::string, std::string, std::less<>> lines_;
};

}  // namespace livegs

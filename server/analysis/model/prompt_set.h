// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/text/json_text.h"
#include "analysis/text/message_templates.h"
#include "core/result.h"

namespace livegs {

// Texts of prompts/ in the form of requests. Read once, then immutable; any thread.
class PromptSet {
 public:
  // Loads the built-in texts, with files of the same name in `folder` replacing them; an empty path replaces
  // none. Fails on an invalid file: not JSON, a template without its slots or with an unknown slot. The error
  // contains the path of the file. Files with other names are ignored with a log line.
  static Result<PromptSet> load(const std::filesystem::path& folder);

  const std::string& version() const { return version_; }  // "1-3f2a9c01d2e4"

  std::string system(int example_count) const;
  std::string user(std::map<std::string, std::string> slots) const;
  std::string tools_turn() const;
  std::string answer_turn(bool schema_in_words) const;
  std::string repair(std::string_view problem) const;
  std::string caption(const std::string& name) const;  // caption of a picture, or its name if it has none
  std::string search(const std::map<std::string, std::string>& slots) const;

  const MessageTemplates& words() const { return words_; }
  const OrderedJson& answer_schema() const { return schema_; }
  const std::vector<std::string>& answer_fields() const { return fields_; }
  // Those that the schema does not allow to be null.
  const std::vector<std::string>& needed_fields() const { return needed_; }
  const OrderedJson& tools() const { return tools_; }  // in the form of a request
  int example_count() const { return static_cast<int>(examples_.size()); }

 private:
  const std::string& text(const char* name) const { return texts_.find(name)->second; }

  std::map<std::string, std::string> texts_;
  std::string version_;
  MessageTemplates words_ = MessageTemplates::built_in();
  OrderedJson schema_, tools_, examples_;
  Json captions_;
  std::vector<std::string> fields_, needed_;
};

}  // namespace livegs

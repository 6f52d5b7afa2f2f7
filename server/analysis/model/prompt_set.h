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

// The texts of prompts/, ready to be sent. Read once; then immutable, any thread.
class PromptSet {
 public:
  // What is compiled in, with the files of `folder` in place of those of the same name; an empty path: none.
  // Fails on a file that is not what its name says: no JSON, a template without its slots or with one that
  // nothing fills. The message has the file's path. A file of another name is told in the log and not read.
  static Result<PromptSet> load(const std::filesystem::path& folder);

  const std::string& version() const { return version_; }  // "1-3f2a9c01d2e4"

  std::string system(int example_count) const;
  std::string user(std::map<std::string, std::string> slots) const;
  std::string tools_turn() const;
  std::string answer_turn(bool schema_in_words) const;
  std::string repair(std::string_view problem) const;
  std::string caption(
      const std::string& name) const;  // of a picture: its words, or the name where there are none
  std::string search(const std::map<std::string, std::string>& slots) const;

  const MessageTemplates& words() const { return words_; }
  const OrderedJson& answer_schema() const { return schema_; }
  const std::vector<std::string>& answer_fields() const { return fields_; }
  const OrderedJson& tools() const { return tools_; }  // as a request has them
  int example_count() const { return static_cast<int>(examples_.size()); }

 private:
  const std::string& text(const char* name) const { return texts_.find(name)->second; }

  std::map<std::string, std::string> texts_;
  std::string version_;
  MessageTemplates words_ = MessageTemplates::built_in();
  OrderedJson schema_, tools_, examples_;
  Json captions_;
  std::vector<std::string> fields_;
};

}  // namespace livegs

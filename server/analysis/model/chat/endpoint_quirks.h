// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "analysis/model/chat/chat_reply.h"

// Actual capabilities of an OpenAI-compatible server. The initial profile follows from the detected server.
// Each refusal then removes the request part that it names or implies, until the server accepts. Learned per
// address and model.

namespace livegs {

enum class Dialect { Unknown, OpenAi, Vllm, LlamaCpp, Ollama, Plain };
enum class AnswerForm { JsonSchema, JsonObject, Text };  // each step requires less of the server
enum class LimitKey { MaxCompletionTokens, MaxTokens, None };

struct EndpointQuirks {
  Dialect dialect = Dialect::Unknown;
  LimitKey limit_key = LimitKey::MaxTokens;
  bool limit_key_swapped = false;
  AnswerForm form = AnswerForm::JsonSchema;
  bool tools = true, tool_choice = true, strict_tools = true;
  bool temperature = true, seed = true;
  bool images = true;
  int examples = 6;  // worked examples in the prompt; fewer if the context is short
  bool stream = true, stream_options = true;
  bool web_search = true;
  friend bool operator==(const EndpointQuirks&, const EndpointQuirks&) = default;
};

const char* dialect_name(Dialect dialect);
EndpointQuirks profile_of(Dialect dialect);
// Dialect from the address alone: api.openai.com, port 11434. Unknown for other addresses.
Dialect dialect_of_url(std::string_view base_url);
// Dialect from the list of models (GET /models); sets `first_model` to the id of the first one.
Dialect dialect_of_models(std::string_view body, std::string& first_model);

// Features of one request beyond plain text.
struct RequestFeatures {
  bool tools = false, images = false, stream = false, web_search = false;
  AnswerForm form = AnswerForm::Text;
};

// Disables the feature that a refusal names. Without `named_only`, guesses one if none is named. Returns the
// name of the feature for the log, or "" if no candidate is left or the refusal has another cause.
std::string learn_from_refusal(EndpointQuirks& quirks, const ServerError& error, const RequestFeatures& sent,
                               bool named_only);

// True if the error is about a prompt longer than the model's context.
bool is_context_overflow(const ServerError& error);

// Store of quirks in memory and, if a file is given, in a small JSON file. Entries expire after 30 days. An
// unreadable or unwritable file only causes a warning. Any thread.
class QuirkMemory {
 public:
  explicit QuirkMemory(std::filesystem::path file);
  bool recall(const std::string& key, EndpointQuirks& quirks) const;
  void keep(const std::string& key, const EndpointQuirks& quirks);

 private:
  void save() const;
  struct Entry {
    EndpointQuirks quirks;
    std::int64_t learned_unix_s = 0;
  };
  std::filesystem::path file_;
  mutable std::mutex mutex_;  // guards entries_
  std::map<std::string, Entry> entries_;
};

}  // namespace livegs

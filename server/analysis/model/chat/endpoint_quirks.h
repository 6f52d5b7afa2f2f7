// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "analysis/model/chat/chat_reply.h"

// What a server that calls itself OpenAI-compatible really takes. A profile to begin with, by who the server
// seems to be; then every refusal that names (or leaves guessing) a part of the request takes that part away,
// until the server is content. Learned per address and model.

namespace livegs {

enum class Dialect { Unknown, OpenAi, Vllm, LlamaCpp, Ollama, Plain };
enum class AnswerForm { JsonSchema, JsonObject, Text };  // each step asks less of the server
enum class LimitKey { MaxCompletionTokens, MaxTokens, None };

struct EndpointQuirks {
  Dialect dialect = Dialect::Unknown;
  LimitKey limit_key = LimitKey::MaxTokens;
  bool limit_key_swapped = false;
  AnswerForm form = AnswerForm::JsonSchema;
  bool tools = true, tool_choice = true, strict_tools = true;
  bool temperature = true, seed = true;
  bool images = true;
  int examples = 6;  // worked examples in the prompt; fewer where the context is short
  bool stream = true, stream_options = true;
  bool web_search = true;
  friend bool operator==(const EndpointQuirks&, const EndpointQuirks&) = default;
};

const char* dialect_name(Dialect dialect);
EndpointQuirks profile_of(Dialect dialect);
// By address alone: api.openai.com, port 11434. Unknown where that says nothing.
Dialect dialect_of_url(std::string_view base_url);
// By the list of models (GET /models); `first_model` is set to the first one's id.
Dialect dialect_of_models(std::string_view body, std::string& first_model);

// What one request asked of the server beyond plain text.
struct RequestFeatures {
  bool tools = false, images = false, stream = false, web_search = false;
  AnswerForm form = AnswerForm::Text;
};

// Takes away what the refusal is about. With `named_only` nothing is guessed. Returns what was taken away,
// for the log; "" when there is nothing left to try or the refusal is about something else.
std::string learn_from_refusal(EndpointQuirks& quirks, const ServerError& error, const RequestFeatures& sent,
                               bool named_only);

// Whether the words are about a prompt that is longer than the model's context.
bool is_context_overflow(const ServerError& error);

// Remembered in memory and, where a file is named, in a small JSON file; what is older than 30 days is
// learned anew. Any thread. A file that cannot be read or written costs a warning, never an answer.
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

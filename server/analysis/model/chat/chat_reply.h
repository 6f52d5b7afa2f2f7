// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/text/json_text.h"
#include "core/result.h"

// Lenient decoder of chat-completions replies: OpenAI, vLLM, llama.cpp, Ollama and gateways differ in
// details. Any bytes give a value or an error.

namespace livegs {

struct ToolCall {
  std::string id, name, arguments;  // arguments as received from the model; normally JSON
};

// Error object in one of the forms {"error": {...}}, {"error": "text"} or {"object": "error", ...}.
struct ServerError {
  std::string code, type, param, message;
};

struct ChatReply {
  // `content` is the text of the thoughts if the server puts the whole reply there.
  std::string content, refusal, finish_reason, model;
  std::vector<ToolCall> tool_calls;  // at most 32
  bool has_choice = false;
  std::int64_t prompt_tokens = 0, completion_tokens = 0;
  double cost_usd = 0;
  std::optional<ServerError> error;  // may accompany status 200
};

// Decodes the body of a reply of any status: one object, or an event stream.
Result<ChatReply> decode_chat_reply(std::string_view body, bool event_stream);

// Incremental decoder of an event stream.
class ChatStream {
 public:
  void add(std::string_view data);
  bool ended() const { return ended_; }  // after [DONE] or an error
  ChatReply take();

 private:
  ChatReply reply_;
  std::string reasoning_;
  std::vector<std::pair<int, ToolCall>> calls_;  // by the server's index
  bool ended_ = false;
};

// First line of a server's text, truncated for a log.
std::string brief(std::string_view text, std::size_t longest = 200);

}  // namespace livegs

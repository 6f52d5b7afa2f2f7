// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "analysis/model/chat/chat_reply.h"
#include "analysis/model/chat/endpoint_quirks.h"
#include "analysis/model/conversation.h"

namespace livegs {

// One message of a conversation.
struct ChatTurn {
  std::string role;  // system, user, assistant, tool
  std::string text;
  std::vector<AnalysisImage> images;  // of a user's turn
  std::vector<ToolCall> calls;        // of an assistant's turn
  std::string call_id;                // of a tool's turn: which call it answers
};

// What a request asks for. Tools and an answer form never stand in one request: servers drop the one or the
// other.
struct ChatRequest {
  std::string model;
  std::int64_t max_tokens = 0;
  bool stream = false, web_search = false;
  const OrderedJson* tools = nullptr;          // null: none
  const OrderedJson* answer_schema = nullptr;  // null: free text
};

RequestFeatures features_of(const ChatRequest& request, const std::vector<ChatTurn>& turns,
                            const EndpointQuirks& quirks);

// The body of POST /chat/completions, as far as `quirks` let it be. With `for_people` the pictures are left
// out and named by their hash.
std::string chat_request_body(const ChatRequest& request, const std::vector<ChatTurn>& turns,
                              const EndpointQuirks& quirks, bool for_people = false);

// RFC 4648, without line breaks.
std::string base64(std::string_view bytes);

}  // namespace livegs

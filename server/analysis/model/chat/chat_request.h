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
  std::string call_id;                // of a tool's turn: the call it answers
};

// Contents of a request. Tools and an answer form are never combined, because servers drop one of them.
struct ChatRequest {
  std::string model;
  std::int64_t max_tokens = 0;
  bool stream = false, web_search = false;
  const OrderedJson* tools = nullptr;          // null: none
  const OrderedJson* answer_schema = nullptr;  // null: free text
};

RequestFeatures features_of(const ChatRequest& request, const std::vector<ChatTurn>& turns,
                            const EndpointQuirks& quirks);

// Body of POST /chat/completions, restricted by `quirks`. With `for_people`, pictures are replaced by their
// hashes.
std::string chat_request_body(const ChatRequest& request, const std::vector<ChatTurn>& turns,
                              const EndpointQuirks& quirks, bool for_people = false);

// RFC 4648, without line breaks.
std::string base64(std::string_view bytes);

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/chat_reply.h"

#include <algorithm>
#include <cmath>

#include "analysis/model/chat/sse_parser.h"

namespace livegs {
namespace {

constexpr std::size_t kMaxReplyToolCalls = 32;
constexpr double kMaxTokenCount = 1e12;

std::string text_or_number(const Json& object, const char* key) {
  const Json* value = member(object, key);
  if (!value) return "";
  if (value->is_string()) return value->get<std::string>();
  return value->is_number_integer() ? dump_json(*value) : "";
}

std::optional<ServerError> read_error(const Json& body) {
  const Json* error = member(body, "error");
  if (error && error->is_null()) error = nullptr;
  if (!error && text_member(body, "object") == "error") error = &body;
  if (!error) {
    // FastAPI's form, used by gateways.
    if (const Json* detail = member(body, "detail"); detail && !member(body, "choices")) {
      return ServerError{"", "", "", detail->is_string() ? detail->get<std::string>() : dump_json(*detail)};
    }
    return std::nullopt;
  }
  if (error->is_string()) return ServerError{"", "", "", error->get<std::string>()};
  ServerError read;
  read.code = text_or_number(*error, "code");
  read.type = text_member(*error, "type");
  read.param = text_member(*error, "param");
  read.message = text_member(*error, "message");
  if (read.message.empty()) read.message = dump_json(*error);
  return read;
}

std::int64_t count_member(const Json& usage, const char* key) {
  const double count = number_member(usage, key).value_or(0);
  return count > 0 && count < kMaxTokenCount ? static_cast<std::int64_t>(count) : 0;
}

void read_usage(const Json& body, ChatReply& reply) {
  const Json* usage = member(body, "usage");
  if (!usage) return;
  reply.prompt_tokens = count_member(*usage, "prompt_tokens");
  reply.completion_tokens = count_member(*usage, "completion_tokens");
  const double cost = number_member(*usage, "cost").value_or(0);
  if (std::isfinite(cost) && cost > 0 && cost < 1e6) reply.cost_usd = cost;
}

// Text, or an array of text parts.
std::string read_content(const Json& message) {
  const Json* content = member(message, "content");
  if (!content) return "";
  if (content->is_string()) return content->get<std::string>();
  std::string joined;
  if (content->is_array()) {
    for (const Json& part : *content) joined += text_member(part, "text");
  } else if (content->is_object()) {
    joined = dump_json(*content);
  }
  return joined;
}

// The thoughts of a reasoning model: `reasoning` (OpenRouter, vLLM, Ollama) or `reasoning_content` (DeepSeek,
// llama.cpp).
std::string read_reasoning(const Json& message) {
  std::string text = text_member(message, "reasoning_content");
  return text.empty() ? text_member(message, "reasoning") : text;
}

// Some servers put the whole reply of a reasoning model into its thoughts and leave the content empty. A
// reply without any JSON there stays empty.
void answer_from_reasoning(ChatReply& reply, std::string reasoning) {
  const bool empty = reply.content.find_first_not_of(" \t\r\n") == std::string::npos;
  if (empty && reply.tool_calls.empty() && reply.refusal.empty() && reasoning.find('{') != std::string::npos)
    reply.content = std::move(reasoning);
}

std::string read_arguments(const Json& function) {
  const Json* arguments = member(function, "arguments");
  if (!arguments || arguments->is_null()) return "";
  return arguments->is_string() ? arguments->get<std::string>() : dump_json(*arguments);
}

void read_tool_calls(const Json& message, std::vector<ToolCall>& calls) {
  if (const Json* list = member(message, "tool_calls"); list && list->is_array()) {
    for (const Json& call : *list) {
      const Json* function = member(call, "function");
      if (!function || calls.size() >= kMaxReplyToolCalls) continue;
      std::string id = text_member(call, "id");
      if (id.empty()) id = "call_" + std::to_string(calls.size());
      calls.push_back({std::move(id), text_member(*function, "name"), read_arguments(*function)});
    }
  }
}

const Json* first_choice(const Json& body) {
  const Json* choices = member(body, "choices");
  return choices && choices->is_array() && !choices->empty() && choices->front().is_object()
             ? &choices->front()
             : nullptr;
}

}  // namespace

void ChatStream::add(std::string_view data) {
  if (ended_) return;
  if (data.starts_with("[DONE]")) {
    ended_ = true;
    return;
  }
  const Result<Json> event = parse_json(data);
  if (!event) {
    reply_.error = ServerError{"", "", "", "an event that is not JSON"};
    ended_ = true;
    return;
  }
  if (auto error = read_error(*event)) {
    reply_.error = std::move(error);
    ended_ = true;
    return;
  }
  if (reply_.model.empty()) reply_.model = text_member(*event, "model");
  read_usage(*event, reply_);
  const Json* choice = first_choice(*event);
  if (!choice) return;  // a usage event has no choice
  reply_.has_choice = true;
  if (std::string reason = text_member(*choice, "finish_reason"); !reason.empty())
    reply_.finish_reason = reason;
  const Json* delta = member(*choice, "delta");
  if (!delta) delta = member(*choice, "message");
  if (!delta) return;
  reply_.content += read_content(*delta);
  reasoning_ += read_reasoning(*delta);
  reply_.refusal += text_member(*delta, "refusal");
  const Json* list = member(*delta, "tool_calls");
  if (!list || !list->is_array()) return;
  for (const Json& part : *list) {
    const double stated = number_member(part, "index").value_or(static_cast<double>(calls_.size()));
    const int index = stated >= 0 && stated < 1000 ? static_cast<int>(stated) : 0;
    auto found =
        std::find_if(calls_.begin(), calls_.end(), [&](const auto& call) { return call.first == index; });
    if (found == calls_.end()) {
      if (calls_.size() >= kMaxReplyToolCalls) continue;
      found = calls_.insert(calls_.end(), {index, ToolCall{}});
    }
    ToolCall& call = found->second;
    if (call.id.empty()) call.id = text_member(part, "id");
    if (const Json* function = member(part, "function")) {
      call.name += text_member(*function, "name");
      call.arguments += read_arguments(*function);
    }
  }
}

ChatReply ChatStream::take() {
  for (auto& [index, call] : calls_) {
    if (call.id.empty()) call.id = "call_" + std::to_string(index);
    reply_.tool_calls.push_back(std::move(call));
  }
  calls_.clear();
  answer_from_reasoning(reply_, std::move(reasoning_));
  return std::move(reply_);
}

Result<ChatReply> decode_chat_reply(std::string_view body, bool event_stream) {
  if (event_stream) {
    SseParser parser;
    ChatStream stream;
    bool any = false;
    const auto add_all = [&](const std::vector<std::string>& events) {
      for (const std::string& event : events) {
        stream.add(event);
        any = true;
      }
    };
    add_all(parser.feed(body));
    add_all(parser.finish());
    if (!any) return invalid_data("an event stream without events");
    ChatReply reply = stream.take();
    if (!reply.error && reply.finish_reason.empty() && !stream.ended()) {
      reply.error = ServerError{"", "", "", "the event stream ended before the answer did"};
    }
    return reply;
  }
  const Result<Json> parsed = parse_json(body);
  if (!parsed) return parsed.error();
  if (!parsed->is_object()) return invalid_data("not a JSON object");
  ChatReply reply;
  reply.error = read_error(*parsed);
  reply.model = text_member(*parsed, "model");
  read_usage(*parsed, reply);
  if (const Json* choice = first_choice(*parsed)) {
    reply.has_choice = true;
    reply.finish_reason = text_member(*choice, "finish_reason");
    if (const Json* message = member(*choice, "message")) {
      reply.content = read_content(*message);
      reply.refusal = text_member(*message, "refusal");
      read_tool_calls(*message, reply.tool_calls);
      answer_from_reasoning(reply, read_reasoning(*message));
    } else {
      reply.content = text_member(*choice, "text");
    }
    if (reply.error && reply.error->message.empty()) reply.error.reset();
  }
  return reply;
}

std::string brief(std::string_view text, std::size_t longest) {
  std::string line;
  for (const char c : text) {
    if (line.size() >= longest) return line + "...";
    line += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  return line;
}

}  // namespace livegs

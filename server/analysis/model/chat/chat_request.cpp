// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/chat/chat_request.h"

#include "core/content_hash.h"

namespace livegs {
namespace {

constexpr const char* kSchemaName = "livegs_analysis_1";
constexpr int kSeed = 1;  // arbitrary but constant, so that answers repeat if the server supports it

OrderedJson image_part(const AnalysisImage& image, bool for_people) {
  const std::string url = for_people ? "sha256:" + content_hash(std::as_bytes(std::span(image.bytes)))
                                     : "data:" + image.media_type + ";base64," + base64(image.bytes);
  return {{"type", "image_url"}, {"image_url", {{"url", url}}}};
}

OrderedJson message_of(const ChatTurn& turn, bool with_images, bool for_people) {
  OrderedJson message = {{"role", turn.role}};
  if (!turn.images.empty() && with_images) {
    OrderedJson parts = OrderedJson::array({{{"type", "text"}, {"text", turn.text}}});
    for (const AnalysisImage& image : turn.images) {
      if (!image.caption.empty()) parts.push_back({{"type", "text"}, {"text", image.caption}});
      parts.push_back(image_part(image, for_people));
    }
    message["content"] = std::move(parts);
  } else {
    message["content"] = turn.text;
  }
  if (!turn.calls.empty()) {
    OrderedJson calls = OrderedJson::array();
    for (const ToolCall& call : turn.calls) {
      // Some servers refuse a history with arguments that are not JSON.
      const bool sound = parse_json(call.arguments).has_value();
      calls.push_back({{"id", call.id},
                       {"type", "function"},
                       {"function", {{"name", call.name}, {"arguments", sound ? call.arguments : "{}"}}}});
    }
    message["tool_calls"] = std::move(calls);
    if (turn.text.empty()) message["content"] = nullptr;
  }
  if (!turn.call_id.empty()) message["tool_call_id"] = turn.call_id;
  return message;
}

}  // namespace

RequestFeatures features_of(const ChatRequest& request, const std::vector<ChatTurn>& turns,
                            const EndpointQuirks& quirks) {
  RequestFeatures features;
  features.tools = request.tools && quirks.tools;
  features.form = request.answer_schema ? quirks.form : AnswerForm::Text;
  features.stream = request.stream && quirks.stream;
  features.web_search = request.web_search && quirks.web_search;
  for (const ChatTurn& turn : turns) features.images |= !turn.images.empty() && quirks.images;
  return features;
}

std::string chat_request_body(const ChatRequest& request, const std::vector<ChatTurn>& turns,
                              const EndpointQuirks& quirks, bool for_people) {
  const RequestFeatures features = features_of(request, turns, quirks);
  OrderedJson messages = OrderedJson::array();
  for (const ChatTurn& turn : turns) messages.push_back(message_of(turn, quirks.images, for_people));
  OrderedJson body = {{"model", request.model}, {"messages", std::move(messages)}};
  if (quirks.limit_key == LimitKey::MaxTokens) body["max_tokens"] = request.max_tokens;
  if (quirks.limit_key == LimitKey::MaxCompletionTokens) body["max_completion_tokens"] = request.max_tokens;
  if (quirks.temperature && !features.web_search) body["temperature"] = 0;
  if (quirks.seed && !features.web_search) body["seed"] = kSeed;
  if (features.stream) {
    body["stream"] = true;
    if (quirks.stream_options) body["stream_options"] = {{"include_usage", true}};
  }
  if (features.web_search) body["web_search_options"] = {{"search_context_size", "low"}};
  if (features.tools) {
    body["tools"] = *request.tools;
    if (quirks.strict_tools) {
      for (OrderedJson& tool : body["tools"]) tool["function"]["strict"] = true;
    }
    if (quirks.tool_choice) body["tool_choice"] = "auto";
  }
  if (features.form == AnswerForm::JsonSchema) {
    body["response_format"] = {
        {"type", "json_schema"},
        {"json_schema", {{"name", kSchemaName}, {"strict", true}, {"schema", *request.answer_schema}}}};
  } else if (features.form == AnswerForm::JsonObject) {
    body["response_format"] = {{"type", "json_object"}};
  }
  return dump_json(body);
}

std::string base64(std::string_view bytes) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t k) -> unsigned {
      return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u;
    };
    const unsigned group = at(0) << 16 | at(1) << 8 | at(2);
    text += kLetters[group >> 18];
    text += kLetters[group >> 12 & 63];
    text += i + 1 < bytes.size() ? kLetters[group >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? kLetters[group & 63] : '=';
  }
  return text;
}

}  // namespace livegs

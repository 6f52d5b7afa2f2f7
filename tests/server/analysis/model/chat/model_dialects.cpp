// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <sstream>

#include "server/analysis/model/chat/model_endpoint_cases.h"

namespace livegs {

const std::string& sound_answer() {
  static const std::string answer = [] {
    std::ifstream file(LIVEGS_TESTS_DIR "/../prompts/examples.json");
    return OrderedJson::parse(file)[0]["answer"].dump();
  }();
  return answer;
}

Json body_of(const SeenRequest& request) { return Json::parse(request.body, nullptr, false); }

std::string last_text(const SeenRequest& request) {
  const Json content = body_of(request)["messages"].back()["content"];
  return content.is_string() ? content.get<std::string>() : content[0]["text"].get<std::string>();
}

Reply says(const std::string& content, const char* finish_reason) {
  Reply reply;
  reply.body = Json{{"id", "chatcmpl-1"},
                    {"model", "test-model-2026"},
                    {"choices",
                     {{{"index", 0},
                       {"finish_reason", finish_reason},
                       {"message", {{"role", "assistant"}, {"content", content}}}}}},
                    {"usage", {{"prompt_tokens", 1500}, {"completion_tokens", 200}}}}
                   .dump(-1, ' ', false, Json::error_handler_t::replace);
  return reply;
}

Reply calls(const std::vector<std::pair<std::string, std::string>>& names_and_arguments) {
  Json list = Json::array();
  for (const auto& [name, arguments] : names_and_arguments) {
    list.push_back({{"id", "call_" + std::to_string(list.size() + 1)},
                    {"type", "function"},
                    {"function", {{"name", name}, {"arguments", arguments}}}});
  }
  Reply reply;
  reply.body = Json{{"choices",
                     {{{"index", 0},
                       {"finish_reason", "tool_calls"},
                       {"message", {{"role", "assistant"}, {"content", nullptr}, {"tool_calls", list}}}}}},
                    {"usage", {{"prompt_tokens", 1500}, {"completion_tokens", 20}}}}
                   .dump();
  return reply;
}

Reply fails(int status, const Json& error) {
  Reply reply;
  reply.status = status;
  reply.body = Json{{"error", error}}.dump();
  return reply;
}

Reply streams(const std::vector<std::string>& events, bool done) {
  Reply reply;
  reply.content_type = "text/event-stream; charset=utf-8";
  reply.body = ": ping\r\n\r\n";
  for (const std::string& event : events) reply.body += "data: " + event + "\n\n";
  if (done) reply.body += "data: [DONE]\n\n";
  return reply;
}

std::vector<std::string> streamed_answer(const std::string& content) {
  std::vector<std::string> events = {
      Json{{"model", "test-model-2026"}, {"choices", {{{"index", 0}, {"delta", {{"role", "assistant"}}}}}}}
          .dump()};
  for (std::size_t at = 0; at < content.size(); at += 37) {
    events.push_back(
        Json{{"choices", {{{"index", 0}, {"delta", {{"content", content.substr(at, 37)}}}}}}}.dump());
  }
  events.push_back(
      Json{{"choices", {{{"index", 0}, {"delta", Json::object()}, {"finish_reason", "stop"}}}}}.dump());
  events.push_back(
      Json{{"choices", Json::array()}, {"usage", {{"prompt_tokens", 1500}, {"completion_tokens", 200}}}}
          .dump());
  return events;
}

TestHttpServer::Handler in_turn(std::vector<Reply> replies) {
  return [replies = std::move(replies)](const SeenRequest&, int index) {
    return replies[std::min(static_cast<std::size_t>(index), replies.size() - 1)];
  };
}

namespace {

bool sends_images(const Json& body) { return body.dump().find("\"image_url\"") != std::string::npos; }

// With tools, two calls at first; then the answer.
Reply answer_or_call(const Json& body) {
  if (body.contains("tools") && body["messages"].back()["role"] == "user") {
    return calls({{"material_search", R"({"query":"terracotta","k":2})"}, {"kb_get", R"({"id":"copper"})"}});
  }
  return says(body.contains("response_format") || body.contains("tools") ? sound_answer()
                                                                         : "Here it is:\n" + sound_answer());
}

}  // namespace

TestHttpServer::Handler openai_server() {
  return [](const SeenRequest& request, int) {
    const Json body = body_of(request);
    if (request.head.find(std::string("Authorization: Bearer ") + kTestKey) == std::string::npos) {
      return fails(401, {{"message", "Incorrect API key provided"}, {"code", "invalid_api_key"}});
    }
    if (body.contains("max_tokens")) {
      return fails(400, {{"message",
                          "Unsupported parameter: 'max_tokens' is not supported with this model. Use "
                          "'max_completion_tokens' instead."},
                         {"type", "invalid_request_error"},
                         {"param", "max_tokens"},
                         {"code", "unsupported_parameter"}});
    }
    if (body.contains("temperature") && body["temperature"] != 1) {
      return fails(400, {{"message", "Unsupported value: 'temperature' does not support 0 with this model."},
                         {"param", "temperature"},
                         {"code", "unsupported_value"}});
    }
    return answer_or_call(body);
  };
}

TestHttpServer::Handler vllm_server() {
  return [](const SeenRequest& request, int) {
    const Json body = body_of(request);
    if (body.contains("tools") && body.value("tool_choice", "") == "auto") {
      Reply reply;
      reply.status = 400;
      reply.body =
          R"({"object":"error","message":"\"auto\" tool choice requires --enable-auto-tool-choice and )"
          R"(--tool-call-parser to be set","type":"BadRequestError","param":null,"code":400})";
      return reply;
    }
    return answer_or_call(body);
  };
}

TestHttpServer::Handler llama_cpp_server() {
  return [](const SeenRequest& request, int index) {
    const Json body = body_of(request);
    if (index == 0)
      return fails(503, {{"message", "Loading model"}, {"type", "unavailable_error"}, {"code", 503}});
    if (body.contains("tools")) {
      return fails(
          500, {{"message", "tools param requires --jinja flag"}, {"type", "server_error"}, {"code", 500}});
    }
    return answer_or_call(body);
  };
}

TestHttpServer::Handler ollama_server() {
  return [](const SeenRequest& request, int) {
    const Json body = body_of(request);
    if (body.contains("tools")) {
      return fails(400, {{"message", "registry.ollama.ai/library/llava:7b does not support tools"},
                         {"type", "api_error"},
                         {"param", nullptr},
                         {"code", nullptr}});
    }
    Reply reply = answer_or_call(body);
    Json json = Json::parse(reply.body);
    json["usage"] = {{"prompt_tokens", 3896}, {"completion_tokens", 200}};
    reply.body = json.dump();
    return reply;
  };
}

TestHttpServer::Handler plain_server() {
  return [](const SeenRequest& request, int) {
    const Json body = body_of(request);
    for (const auto& [key, value] : body.items()) {
      if (key != "model" && key != "messages" && key != "max_tokens") {
        return fails(400, {{"message", "Extra inputs are not permitted"}});
      }
    }
    if (sends_images(body)) return fails(400, {{"message", "Extra inputs are not permitted"}});
    return says("Let me think {about} it.\n```json\n" + sound_answer() + "\n```\nThat is all.");
  };
}

}  // namespace livegs

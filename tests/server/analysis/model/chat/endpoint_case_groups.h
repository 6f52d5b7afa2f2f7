// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>
#include <string>
#include <vector>

#include "server/analysis/model/chat/model_endpoint_cases.h"

// Groups of endpoint_cases(), and their shared helpers.

namespace livegs {

std::vector<EndpointCase> dialect_cases();  // well-behaved servers
std::vector<EndpointCase> tool_cases();     // valid and invalid tool calls
std::vector<EndpointCase> refusal_cases();  // 4xx that name an unsupported part, or are final
std::vector<EndpointCase> busy_cases();     // rate limits, quotas, failures, delays
std::vector<EndpointCase> content_cases();  // contents of replies of status 200
std::vector<EndpointCase> stream_cases();   // server-sent events

using Posts = std::vector<SeenRequest>;
using Settings = EndpointSettings;

inline void no_tools(Settings& settings) { settings.tools = false; }
inline void streaming(Settings& settings) {
  settings.tools = false;
  settings.stream = true;
  settings.first_byte_timeout_s = 10;
  settings.stall_timeout_s = 10;
}

inline Reply plain(int status, std::string body, std::string type = "application/json") {
  Reply reply;
  reply.status = status;
  reply.body = std::move(body);
  reply.content_type = std::move(type);
  return reply;
}

inline Reply with_header(Reply reply, std::string line) {
  reply.headers.push_back(std::move(line));
  return reply;
}

inline std::string http_date(int seconds_from_now) {
  const std::time_t moment = std::time(nullptr) + seconds_from_now;
  char text[64];
  std::tm parts{};
  ::gmtime_r(&moment, &parts);
  std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &parts);
  return text;
}

inline Reply models_of(const char* owner) {
  Reply reply;
  reply.body = Json{{"object", "list"}, {"data", {{{"id", "qwen-vl"}, {"owned_by", owner}}}}}.dump();
  return reply;
}

inline Json error_of(const char* code, const char* message) {
  return {{"message", message}, {"type", code}, {"code", code}, {"param", nullptr}};
}

// Result of the first tool call, as sent to the model.
inline std::string tool_result(const Posts& posts, std::size_t call = 0) {
  const Json messages = body_of(posts.at(1))["messages"];
  std::size_t seen = 0;
  for (const Json& message : messages) {
    if (message["role"] == "tool" && seen++ == call) return message["content"];
  }
  return "";
}

inline TestHttpServer::Handler one_call(const std::string& name, const std::string& arguments) {
  return in_turn({calls({{name, arguments}}), says(sound_answer())});
}

// Responds with a 400 about `param` while the request contains it.
inline TestHttpServer::Handler refuses(const std::string& key, const Json& error, int status = 400) {
  return [=](const SeenRequest& request, int) {
    return body_of(request).contains(key) ? fails(status, error) : says(sound_answer());
  };
}

}  // namespace livegs

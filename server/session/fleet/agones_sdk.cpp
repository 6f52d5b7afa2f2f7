// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/fleet/agones_sdk.h"

#include <charconv>
#include <cstdlib>
#include <cstring>

#include "analysis/text/json_text.h"
#include "core/text/shown_text.h"
#include "store/http_client.h"

namespace livegs {
namespace {

constexpr int kDefaultSdkPort = 9358;
// The sidecar is on this machine and replies from memory. A longer wait would delay Health.
constexpr double kSdkCallTimeout_s = 1;

// Agones sends status 500 for a counter that the spec lacks and for a feature that is off, as for a fault of
// the moment. Only the text tells them apart: these two stay, and any other is worth a repetition.
ErrorCode code_of_refusal(int status, const std::string& body) {
  const auto says = [&](const char* text) { return body.find(text) != std::string::npos; };
  if (status == 404 || says("counter not found") || says("not enabled")) return ErrorCode::NotFound;
  return status >= 500 ? ErrorCode::Unavailable : ErrorCode::Internal;
}

Result<void> without_body(const Result<std::string>& reply) {
  return reply ? Result<void>() : Result<void>(reply.error());
}

}  // namespace

AgonesSdk::AgonesSdk(int port)
    : url_("http://localhost:" + std::to_string(port)), http_(std::make_unique<HttpClient>()) {}
AgonesSdk::~AgonesSdk() = default;

Result<int> AgonesSdk::port_of_environment() {
  const char* text = std::getenv("AGONES_SDK_HTTP_PORT");
  if (text == nullptr || *text == 0) return kDefaultSdkPort;
  int port = 0;
  const char* end = text + std::strlen(text);
  const auto read = std::from_chars(text, end, port);
  if (read.ec != std::errc() || read.ptr != end || port < 1 || port > 65535)
    return invalid_argument("AGONES_SDK_HTTP_PORT: " + quoted_name(text) + " is not a port; use 1 to 65535");
  return port;
}

Result<std::string> AgonesSdk::call(std::string_view method, const std::string& path, std::string body,
                                    std::stop_token stop) {
  HttpRequest request;
  request.url = url_ + path;
  request.method = method;
  request.body = std::move(body);
  request.connect_timeout_s = request.total_timeout_s = kSdkCallTimeout_s;
  HttpReply reply = http_->send(request, stop);
  const std::string what = "agones: " + std::string(method) + " " + path + ": ";
  if (reply.end != HttpReply::End::Complete) return Error{ErrorCode::Unavailable, what + reply.message};
  if (reply.status == 200) return std::move(reply.body);
  return Error{code_of_refusal(reply.status, reply.body),
               what + "status " + std::to_string(reply.status) + ": " + shown_line(reply.body)};
}

Result<GameServer> parse_game_server(std::string_view json) {
  const auto parsed = parse_json(json);
  if (!parsed) return parsed.error();
  const Json* about = member(*parsed, "object_meta");
  const Json* status = member(*parsed, "status");
  if (about == nullptr || text_member(*about, "name").empty())
    return invalid_data("agones: the reply to /gameserver has no object_meta.name");
  GameServer server;
  server.name = text_member(*about, "name");
  if (status != nullptr) server.state = text_member(*status, "state");
  if (const Json* annotations = member(*about, "annotations"); annotations != nullptr) {
    server.next_address = text_member(*annotations, kNextAddressAnnotation);
    server.next_server = text_member(*annotations, kNextServerAnnotation);
  }
  return server;
}

Result<GameServer> AgonesSdk::game_server(std::stop_token stop) {
  const auto reply = call("GET", "/gameserver", "", stop);
  if (!reply) return reply.error();
  return parse_game_server(*reply);
}

Result<void> AgonesSdk::ready(std::stop_token stop) {
  return without_body(call("POST", "/ready", "{}", stop));
}

Result<void> AgonesSdk::allocate(std::stop_token stop) {
  return without_body(call("POST", "/allocate", "{}", stop));
}

Result<void> AgonesSdk::shutdown(std::stop_token stop) {
  return without_body(call("POST", "/shutdown", "{}", stop));
}

Result<void> AgonesSdk::health(std::stop_token stop) {
  return without_body(call("POST", "/health", "{}", stop));
}

Result<void> AgonesSdk::set_label(const std::string& key, const std::string& value, std::stop_token stop) {
  return without_body(call("PUT", "/metadata/label", dump_json(Json{{"key", key}, {"value", value}}), stop));
}

Result<void> AgonesSdk::set_counter(const std::string& name, uint64_t count, uint64_t capacity,
                                    std::stop_token stop) {
  // 64-bit integers are texts in the JSON form of protobuf.
  const Json body{{"count", std::to_string(count)}, {"capacity", std::to_string(capacity)}};
  return without_body(call("PATCH", "/v1beta1/counters/" + name, dump_json(body), stop));
}

}  // namespace livegs

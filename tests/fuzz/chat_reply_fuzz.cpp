// SPDX-License-Identifier: Apache-2.0
// What a chat-completions server sends back. The first byte tells of what kind the rest is (odd: an event
// stream) and where the stream is cut: its events do not depend on that.
#include <nlohmann/json.hpp>

#include "analysis/model/chat/chat_reply.h"
#include "analysis/model/chat/sse_parser.h"
#include "fuzz/fuzz_target.h"
#include "server/analysis/gate/answer_mutations.h"

namespace livegs::fuzz::chat_reply_fuzz {
namespace {

constexpr size_t kMaxCalls = 32;

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<std::string> events_of(std::string_view stream, size_t piece) {
  SseParser parser;
  std::vector<std::string> events;
  const auto add = [&](std::vector<std::string> more) {
    for (std::string& event : more) events.push_back(std::move(event));
  };
  for (size_t at = 0; at < stream.size(); at += piece) add(parser.feed(stream.substr(at, piece)));
  add(parser.finish());
  return events;
}

Bytes input(uint8_t kind, const std::string& body) {
  Bytes bytes{static_cast<std::byte>(kind)};
  for (const char c : body) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

nlohmann::json reply_with(const nlohmann::json& message, const char* key) {
  return {{"model", "m"},
          {"choices", {{{"index", 0}, {key, message}, {"finish_reason", "stop"}}}},
          {"usage", {{"prompt_tokens", 1500}, {"completion_tokens", 200}, {"cost", 0.01}}}};
}

}  // namespace

void look_at(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  const auto kind = std::to_integer<size_t>(bytes[0]);
  const std::string_view body = text_of(bytes.subspan(1));
  const bool stream = (kind & 1) != 0;
  const auto reply = decode_chat_reply(body, stream);
  if (reply) {
    check(reply->tool_calls.size() <= kMaxCalls, "tool calls are bounded");
    check(reply->prompt_tokens >= 0 && reply->completion_tokens >= 0 && reply->cost_usd >= 0,
          "counts are counts");
    check(reply->content.size() <= body.size() * 2 + 64, "text is not made up");
  } else {
    check(reply.error().message.find('\n') == std::string::npos, "an error is one line");
  }
  check(brief(body).find('\n') == std::string::npos, "what is shown of it is one line");
  if (stream)
    check(events_of(body, 1 + kind / 2) == events_of(body, bytes.size()), "events do not depend on the cuts");
}

std::vector<Bytes> seeds() {
  using nlohmann::json;
  const json call = {
      {"index", 0}, {"id", "a"}, {"function", {{"name", "shell_mass"}, {"arguments", "{\"area_m2\":2}"}}}};
  const json says = {{"content", "{\"mass_g\": 330, \"name\": \"tasse \u00e0 caf\u00e9\"}"}},
             calls = {{"tool_calls", {call, call}}};
  const json refuses = {{"content", nullptr}, {"refusal", "no"}};
  std::vector<Bytes> seeds;
  for (const json& message : {says, calls, refuses}) {
    seeds.push_back(input(0, reply_with(message, "message").dump()));
    std::string stream = ": ping\r\n\r\n";
    for (int i = 0; i < 3; ++i)
      stream += "data: " + reply_with(message, "delta").dump() + (i ? "\n\n" : "\r\n\r\n");
    seeds.push_back(input(7, stream + "data: [DONE]\n\n"));
  }
  seeds.push_back(
      input(0, R"({"error":{"code":"insufficient_quota","message":"no credit","type":"t","param":"p"}})"));
  seeds.push_back(input(0, R"({"object":"error","message":"too long","code":400})"));
  // Spoilt as answers are.
  for (uint64_t seed = 0; seed < 40; ++seed) {
    AnswerMutator mutator(seed);
    seeds.push_back(input(static_cast<uint8_t>(2 * seed),
                          mutator.mutate(reply_with(seed % 2 ? says : calls, "message"))));
    seeds.push_back(input(static_cast<uint8_t>(2 * seed + 1),
                          "data: " + mutator.mutate(reply_with(says, "delta")) + "\n\n"));
  }
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"chat_reply", look_at, seeds});

}  // namespace livegs::fuzz::chat_reply_fuzz

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "analysis/model/model_endpoint.h"
#include "analysis/text/json_text.h"
#include "test_http_server.h"

// Table of server behaviours and the expected results in the client.

namespace livegs {

inline constexpr const char* kTestKey = "sk-live-7QmZr4T9xVb2LwK8pYc3NdHs";

// A complete answer, the first example of prompts/examples.json; its mass_g.best is 730.
const std::string& sound_answer();

// Chat reply in OpenAI's form.
Reply says(const std::string& content, const char* finish_reason = "stop");
Reply calls(const std::vector<std::pair<std::string, std::string>>& names_and_arguments);
Reply fails(int status, const Json& error);  // {"error": ...}
Reply streams(const std::vector<std::string>& events, bool done = true);
std::vector<std::string> streamed_answer(const std::string& content);  // its events

Json body_of(const SeenRequest& request);
std::string last_text(const SeenRequest& request);  // of the last message

// Servers of the four dialects and plain text, each with its refusals.
TestHttpServer::Handler openai_server();
TestHttpServer::Handler vllm_server();
TestHttpServer::Handler llama_cpp_server();
TestHttpServer::Handler ollama_server();
TestHttpServer::Handler plain_server();

struct EndpointCase {
  std::string name;
  TestHttpServer::Handler server;
  std::string error;  // expected part of the error message; empty: an answer is expected
  int posts = -1;     // expected number of requests; -1: any
  std::function<void(EndpointSettings&)> settings = {};
  std::function<void(const std::vector<SeenRequest>& posts, const RawAnswer& answer)> check = {};
  Reply models = not_found_reply();
};
const std::vector<EndpointCase>& endpoint_cases();

// Settings of every case: this server, the test key, delays of milliseconds.
EndpointSettings test_settings(const std::string& base_url);

// Sends the replies in order and repeats the last one.
TestHttpServer::Handler in_turn(std::vector<Reply> replies);

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "model_endpoint_cases.h"

#include <ctime>

#include <gtest/gtest.h>

namespace livegs {
namespace {

using Posts = std::vector<SeenRequest>;
using Settings = EndpointSettings;

void no_tools(Settings& settings) { settings.tools = false; }
void streaming(Settings& settings) {
  settings.tools = false;
  settings.stream = true;
  settings.first_byte_timeout_s = 10;
  settings.stall_timeout_s = 10;
}

Reply plain(int status, std::string body, std::string type = "application/json") {
  Reply reply;
  reply.status = status;
  reply.body = std::move(body);
  reply.content_type = std::move(type);
  return reply;
}

Reply with_header(Reply reply, std::string line) {
  reply.headers.push_back(std::move(line));
  return reply;
}

std::string http_date(int seconds_from_now) {
  const std::time_t moment = std::time(nullptr) + seconds_from_now;
  char text[64];
  std::tm parts{};
  ::gmtime_r(&moment, &parts);
  std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &parts);
  return text;
}

Reply models_of(const char* owner) {
  Reply reply;
  reply.body = Json{{"object", "list"}, {"data", {{{"id", "qwen-vl"}, {"owned_by", owner}}}}}.dump();
  return reply;
}

Json error_of(const char* code, const char* message) {
  return {{"message", message}, {"type", code}, {"code", code}, {"param", nullptr}};
}

// What the model is told about the result of its first call.
std::string tool_result(const Posts& posts, std::size_t call = 0) {
  const Json messages = body_of(posts.at(1))["messages"];
  std::size_t seen = 0;
  for (const Json& message : messages) {
    if (message["role"] == "tool" && seen++ == call) return message["content"];
  }
  return "";
}

TestModelServer::Handler one_call(const std::string& name, const std::string& arguments) {
  return in_turn({calls({{name, arguments}}), says(sound_answer())});
}

// A 400 about `param` as long as it is sent.
TestModelServer::Handler refuses(const std::string& key, const Json& error, int status = 400) {
  return [=](const SeenRequest& request, int) {
    return body_of(request).contains(key) ? fails(status, error) : says(sound_answer());
  };
}

std::vector<EndpointCase> dialect_cases() {
  return {
      {"openai_learns_its_two_parameters",
       openai_server(),
       "",
       4,
       {},
       [](const Posts& posts, const RawAnswer& answer) {
         EXPECT_EQ(body_of(posts.back())["max_completion_tokens"], 4 * 2000);
         EXPECT_NE(tool_result({posts[2], posts[3]}).find("material:terracotta"), std::string::npos);
         EXPECT_EQ(answer.completion_tokens, 220);
       }},
      {"vllm_without_a_tool_parser",
       vllm_server(),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) {
         EXPECT_EQ(body_of(posts.back())["response_format"]["json_schema"]["strict"], true);
       },
       models_of("vllm")},
      {"llama_cpp_loads_and_has_no_jinja",
       llama_cpp_server(),
       "",
       3,
       {},
       [](const Posts& posts, const RawAnswer&) { EXPECT_FALSE(body_of(posts.back()).contains("tools")); },
       models_of("llamacpp")},
      {"ollama_cuts_the_prompt_and_is_found_out",
       ollama_server(),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer& answer) {
         EXPECT_FALSE(body_of(posts.front()).contains("tool_choice"));
         ASSERT_EQ(answer.warnings.size(), 1u);
         EXPECT_NE(answer.warnings[0].find("OLLAMA_CONTEXT_LENGTH"), std::string::npos);
       },
       models_of("library")},
      {"plain_text_only",
       plain_server(),
       "",
       7,
       {},
       [](const Posts& posts, const RawAnswer&) {
         // The schema stands in words where it cannot stand in the request.
         EXPECT_NE(last_text(posts.back()).find("\"additionalProperties\""), std::string::npos);
         EXPECT_EQ(body_of(posts.back()).size(), 3u);
       }},
      {"the_first_listed_model_is_taken", in_turn({says(sound_answer())}), "", 1,
       [](Settings& settings) { settings.model.clear(); },
       [](const Posts& posts, const RawAnswer&) { EXPECT_EQ(body_of(posts[0])["model"], "qwen-vl"); },
       models_of("vllm")},
      {"no_model_is_named_or_listed", in_turn({says(sound_answer())}), "LIVEGS_MODEL", 0,
       [](Settings& settings) { settings.model.clear(); }},
  };
}

std::vector<EndpointCase> tool_cases() {
  std::vector<Reply> endless(20, calls({{"mesh_facts", "{}"}}));
  std::vector<std::pair<std::string, std::string>> many(12, {"mesh_facts", "{}"});
  return {
      {"a_tool_then_the_answer",
       one_call("shell_mass", R"({"area_m2":1,"thickness_mm":1,"density_kg_m3":1000})"),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) { EXPECT_EQ(tool_result(posts), R"({"mass_g":1000.0})"); }},
      {"parallel_tools_are_all_answered",
       in_turn({calls({{"mesh_facts", "{}"}, {"list_scene_objects", "{}"}, {"kb_get", R"({"id":"brass"})"}}),
                says(sound_answer())}),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) {
         const Json messages = body_of(posts[1])["messages"];
         for (int i = 1; i <= 3; ++i) {
           EXPECT_EQ(messages[messages.size() - 4 + static_cast<std::size_t>(i)]["tool_call_id"],
                     "call_" + std::to_string(i));
         }
         EXPECT_NE(tool_result(posts, 2).find("8500"), std::string::npos);
       }},
      {"malformed_arguments",
       one_call("shell_mass", R"({"area_m2": 1, )"),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) {
         EXPECT_NE(tool_result(posts).find("not a JSON object"), std::string::npos);
         // The history that goes back is sound all the same.
         const Json messages = body_of(posts[1])["messages"];
         EXPECT_EQ(messages[messages.size() - 2]["tool_calls"][0]["function"]["arguments"], "{}");
       }},
      {"arguments_of_the_wrong_type",
       one_call("shell_mass", R"({"area_m2":"much","thickness_mm":[],"density_kg_m3":1e999})"), "", 2},
      {"arguments_out_of_range",
       one_call("shell_mass", R"({"area_m2":-1,"thickness_mm":1,"density_kg_m3":1})"),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) {
         EXPECT_NE(tool_result(posts).find("area_m2"), std::string::npos);
       }},
      {"unknown_tool",
       one_call("run_shell", R"({"command":"cat /etc/passwd"})"),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) {
         EXPECT_NE(tool_result(posts).find("no such tool"), std::string::npos);
       }},
      {"at_most_four_rounds",
       [endless](const SeenRequest& request, int) {
         return body_of(request).contains("tools") ? endless[0] : says(sound_answer());
       },
       "", 5},
      {"at_most_eight_calls",
       [many](const SeenRequest& request, int) {
         return body_of(request).contains("tools") ? calls(many) : says(sound_answer());
       },
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) {
         int count = 0;
         const Json messages = body_of(posts[1])["messages"];
         for (const Json& message : messages) count += message["role"] == "tool";
         EXPECT_EQ(count, 8);
       }},
      {"a_whole_answer_instead_of_a_call_is_taken", in_turn({says(sound_answer())}), "", 1},
      {"a_wrong_value_is_for_the_gate_to_find",
       [](const SeenRequest&, int) {
         std::string answer = sound_answer();
         return says(answer.replace(answer.find("open_shell"), 10, "hollow"));
       },
       "", 1},
      {"half_an_answer_instead_of_a_call_is_not",
       in_turn({says(R"({"mass_g":{"low":1,"best":2,"high":3}})"), says(sound_answer())}), "", 2},
      {"chatter_instead_of_a_call",
       in_turn({says("Let me look."), says(sound_answer())}),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) {
         EXPECT_TRUE(body_of(posts[1]).contains("response_format"));
       }},
      {"a_history_of_tools_is_refused",
       [](const SeenRequest& request, int index) {
         if (index == 0) return calls({{"mesh_facts", "{}"}});
         return request.body.find("\"role\":\"tool\"") != std::string::npos &&
                        !body_of(request).contains("tools")
                    ? fails(400, {{"message", "messages with role tool need tools"}})
                : index == 1 ? calls({{"mesh_facts", "{}"}})
                             : says(sound_answer());
       },
       "", -1},
      {"arguments_that_are_an_object",
       in_turn({plain(200,
                      R"({"choices":[{"message":{"tool_calls":[{"function":{"name":"shell_mass","arguments":)"
                      R"({"area_m2":1,"thickness_mm":1,"density_kg_m3":500}}}]}}]})"),
                says(sound_answer())}),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) { EXPECT_EQ(tool_result(posts), R"({"mass_g":500.0})"); }},
  };
}

std::vector<EndpointCase> refusal_cases() {
  const auto schema_refused = [](const SeenRequest& request, int) {
    const Json body = body_of(request);
    if (body.contains("response_format") && body["response_format"]["type"] == "json_schema") {
      return fails(400,
                   error_of("invalid_request_error", "response_format type json_schema is not supported"));
    }
    return says(sound_answer());
  };
  return {
      {"schema_refused_object_taken", schema_refused, "", 2, no_tools,
       [](const Posts& posts, const RawAnswer&) {
         EXPECT_EQ(body_of(posts[1])["response_format"]["type"], "json_object");
         EXPECT_NE(last_text(posts[1]).find("JSON"), std::string::npos);  // OpenAI wants the word
       }},
      {"schema_and_object_refused",
       refuses("response_format", error_of("invalid_request_error", "unknown field response_format")), "", 3,
       no_tools},
      {"schema_passed_over",
       in_turn({says("A pot, about 700 g."), says("A pot, I said."), says(sound_answer())}), "", 3, no_tools},
      {"max_tokens_refused",
       refuses("max_tokens", {{"message", "no"}, {"param", "max_tokens"}, {"code", "unsupported_parameter"}}),
       "", 2, no_tools},
      {"both_limits_refused",
       [](const SeenRequest& request, int) {
         for (const char* key : {"max_tokens", "max_completion_tokens"}) {
           if (body_of(request).contains(key)) {
             return fails(400, {{"message", "Unrecognized request argument supplied: " + std::string(key)}});
           }
         }
         return says(sound_answer());
       },
       "", 3, no_tools},
      {"temperature_refused", refuses("temperature", {{"message", "no"}, {"param", "temperature"}}), "", 2,
       no_tools},
      {"seed_refused", refuses("seed", {{"message", "Unknown parameter: 'seed'."}}), "", 2, no_tools},
      {"strict_tools_refused",
       [](const SeenRequest& request, int) {
         return request.body.find("\"strict\":true},\"type\"") != std::string::npos ||
                        request.body.find("},\"strict\":true}}") != std::string::npos
                    ? fails(400, {{"message", "tools[0].function.strict: extra fields not permitted"}})
                    : says(sound_answer());
       },
       "", 2},
      {"tool_choice_refused", refuses("tool_choice", {{"message", "tool_choice is not supported"}}), "", 2},
      {"pictures_refused",
       [](const SeenRequest& request, int) {
         return request.body.find("image_url") != std::string::npos
                    ? fails(500, {{"message",
                                   "image input is not supported - hint: if this is unexpected, you may need "
                                   "to provide the mmproj"}})
                    : says(sound_answer());
       },
       "", 2, no_tools},
      {"a_400_without_words_of_use", in_turn({plain(400, "Bad Request", "text/plain"), says(sound_answer())}),
       "", 2},
      {"400_for_ever", in_turn({fails(400, {{"message", "no"}})}), "400", -1},
      {"context_overflow",
       in_turn({fails(
           400, error_of("context_length_exceeded", "This model's maximum context length is 4096 tokens"))}),
       "longer than the model's context", 1},
      {"401_is_not_repeated",
       in_turn({fails(401, error_of("invalid_api_key", "Incorrect API key provided"))}), "OPENAI_API_KEY", 1},
      {"401_that_repeats_the_key", in_turn({fails(401, {{"message", "bad key " + std::string(kTestKey)}})}),
       "[key]", 1},
      {"403_is_not_repeated", in_turn({fails(403, error_of("forbidden", "region not allowed"))}),
       "region not allowed", 1},
      {"404_names_the_remedy", in_turn({fails(404, error_of("model_not_found", "model 'x' not found"))}),
       "LIVEGS_MODEL", 1},
      {"413_is_not_repeated", in_turn({plain(413, "<html>too large</html>", "text/html")}), "fewer views", 1},
      {"422_is_not_repeated", in_turn({plain(422, R"({"detail":[{"msg":"field required"}]})")}),
       "field required", 1},
      {"redirects_are_not_followed",
       in_turn({with_header(plain(302, ""), "Location: http://127.0.0.1:1/steal")}), "redirect", 1},
  };
}

std::vector<EndpointCase> busy_cases() {
  const Reply busy = fails(429, error_of("rate_limit_exceeded", "Rate limit reached"));
  const auto short_deadline = [](Settings& settings) {
    settings.tools = false;
    settings.deadline_s = 0.5;
  };
  return {
      {"429_then_an_answer", in_turn({busy, says(sound_answer())}), "", 2, no_tools},
      {"429_with_seconds", in_turn({with_header(busy, "Retry-After: 1"), says(sound_answer())}), "", 2,
       no_tools, [](const Posts&, const RawAnswer& answer) { EXPECT_GE(answer.wall_s, 1.0); }},
      {"429_with_a_date",
       [busy](const SeenRequest&, int index) {
         return index == 0 ? with_header(busy, "Retry-After: " + http_date(2)) : says(sound_answer());
       },
       "", 2, no_tools, [](const Posts&, const RawAnswer& answer) { EXPECT_GE(answer.wall_s, 0.9); }},
      {"429_past_the_deadline", in_turn({with_header(busy, "Retry-After: 3600")}), "past the deadline", 1,
       no_tools},
      {"429_for_ever", in_turn({busy}), "fewer requests", 4, no_tools},
      {"429_no_credit",
       in_turn({fails(429, error_of("insufficient_quota", "You exceeded your current quota"))}),
       "no more credit", 1},
      {"429_spend_limit", in_turn({fails(429, error_of("organization_spend_limit_exceeded", "limit"))}),
       "no more credit", 1},
      {"500_then_an_answer", in_turn({plain(500, "oops", "text/plain"), says(sound_answer())}), "", 2,
       no_tools},
      {"502_html_then_an_answer",
       in_turn({plain(502, "<html>Bad Gateway</html>", "text/html"), says(sound_answer())}), "", 2, no_tools},
      {"503_for_ever", in_turn({plain(503, "")}), "503", 4, no_tools},
      {"503_while_loading_is_waited_for",
       [](const SeenRequest&, int index) {
         return index < 7 ? fails(503, {{"message", "Loading model"}, {"type", "unavailable_error"}})
                          : says(sound_answer());
       },
       "", 8, no_tools},
      {"504_then_an_answer", in_turn({plain(504, ""), says(sound_answer())}), "", 2, no_tools},
      {"529_then_an_answer",
       in_turn({fails(529, {{"type", "overloaded_error"}, {"message", "Overloaded"}}), says(sound_answer())}),
       "", 2, no_tools},
      {"408_then_an_answer", in_turn({plain(408, ""), says(sound_answer())}), "", 2, no_tools},
      {"200_with_an_error_inside",
       in_turn({fails(200, {{"message", "upstream failed"}, {"code", 502}}), says(sound_answer())}), "", 2,
       no_tools},
      {"200_with_a_bare_error",
       in_turn({plain(200, R"({"error":"model runner has stopped"})"), says(sound_answer())}), "", 2,
       no_tools},
      {"200_with_no_credit", in_turn({fails(200, error_of("insufficient_quota", "pay"))}), "no more credit",
       1},
      {"empty_choices", in_turn({plain(200, R"({"choices":[]})"), says(sound_answer())}), "", 2, no_tools},
      {"empty_choices_for_ever", in_turn({plain(200, R"({"choices":[]})")}), "without choices", 4, no_tools},
      {"null_content",
       in_turn({plain(200, R"({"choices":[{"message":{"content":null},"finish_reason":"stop"}]})"),
                says(sound_answer())}),
       "", 2, no_tools},
      {"slow_first_byte",
       [](const SeenRequest&, int index) {
         Reply reply = streams(streamed_answer(sound_answer()));
         reply.delay_ms = index == 0 ? 30000 : 0;
         return reply;
       },
       "", 2,
       [](Settings& settings) {
         streaming(settings);
         settings.first_byte_timeout_s = 1;
       }},
      {"hang_before_the_first_byte",
       [](const SeenRequest&, int) {
         Reply reply;
         reply.hang = true;
         reply.cut_after = 0;
         return reply;
       },
       "in time", 1, short_deadline},
      {"hang_inside_the_body",
       [](const SeenRequest&, int) {
         Reply reply = says(sound_answer());
         reply.hang = true;
         reply.cut_after = 100;
         return reply;
       },
       "in time", 1, short_deadline},
      {"slow_drip",
       [](const SeenRequest&, int) {
         Reply reply = says(sound_answer());
         reply.piece_bytes = 1;
         reply.piece_delay_ms = 20;
         return reply;
       },
       "in time", 1, short_deadline},
      {"stream_that_stalls",
       [](const SeenRequest&, int index) {
         Reply reply = streams(streamed_answer(sound_answer()));
         if (index == 0) {
           reply.cut_after = 300;
           reply.hang = true;
         }
         return reply;
       },
       "", 2,
       [](Settings& settings) {
         streaming(settings);
         settings.stall_timeout_s = 1;
       }},
      {"connection_refused", in_turn({says(sound_answer())}), "is the server running", 0,
       [](Settings& settings) { settings.base_url = "http://127.0.0.1:9/v1"; }},
      {"no_such_host", in_turn({says(sound_answer())}), "is the server running", 0,
       [](Settings& settings) {
         settings.base_url = "http://no-such-host.invalid/v1";
         settings.max_retries = 0;
       }},
      {"connection_cut",
       [](const SeenRequest&, int index) {
         Reply reply = says(sound_answer());
         if (index == 0) reply.cut_after = 50;
         return reply;
       },
       "", 2, no_tools},
      {"cut_before_the_head",
       [](const SeenRequest&, int index) {
         Reply reply = says(sound_answer());
         if (index == 0) reply.raw = "H";
         return reply;
       },
       "", 2, no_tools},
      {"no_http_at_all",
       [](const SeenRequest&, int) {
         Reply reply;
         reply.raw = "SSH-2.0-OpenSSH_9.2\r\n";
         return reply;
       },
       "OPENAI_BASE_URL", 1, no_tools},
      {"no_tls_where_it_should_be", in_turn({says(sound_answer())}), "127.0.0.1", 0,
       [](Settings& settings) {
         settings.base_url.replace(0, 4, "https");
         settings.max_retries = 0;
         settings.connect_timeout_s = settings.probe_timeout_s = 0.2;
       }},
  };
}

std::vector<EndpointCase> content_cases() {
  const std::string answer = sound_answer();
  Reply reasoning = says(answer);
  std::string deep(100000, '[');
  Reply oversize = says(std::string(5 << 20, 'x'));
  Reply bad_utf8 = says("PLACE");
  bad_utf8.body.replace(bad_utf8.body.find("PLACE"), 5, "\xff\xfe\xc3(");
  const auto declines = plain(
      200,
      R"({"choices":[{"message":{"content":null,"refusal":"I can't help with that."},"finish_reason":"stop"}]})");
  return {
      {"truncated_then_longer", in_turn({says(answer.substr(0, 200), "length"), says(answer)}), "", 2,
       no_tools,
       [](const Posts& posts, const RawAnswer&) {
         EXPECT_EQ(body_of(posts[1])["max_tokens"], 2 * body_of(posts[0])["max_tokens"].get<int>());
       }},
      {"truncated_twice", in_turn({says(answer.substr(0, 200), "length")}), "did not end within", 2,
       no_tools},
      {"refusal", in_turn({declines}), "declined", 1, no_tools},
      {"content_filter",
       in_turn({plain(200, R"({"choices":[{"message":{"content":""},"finish_reason":"content_filter"}]})")}),
       "content filter", 1, no_tools},
      {"prose_around_the_json",
       in_turn({says("Sure! Here is {my} answer: " + answer + " Hope that helps {a lot}.")}), "", 1,
       no_tools},
      {"code_fence", in_turn({says("```json\n" + answer + "\n```")}), "", 1, no_tools},
      {"thoughts_with_a_draft",
       in_turn({says(R"(<think>{"mass_g":{"low":1,"best":1,"high":1}}</think>)" + answer)}), "", 1, no_tools},
      {"wrapped_in_another_object", in_turn({says(R"({"answer":)" + answer + "}")}), "", 1, no_tools},
      {"content_in_parts",
       in_turn({plain(200, Json{{"choices",
                                 {{{"message", {{"content", {{{"type", "text"}, {"text", answer}}}}}},
                                   {"finish_reason", "stop"}}}}}
                               .dump())}),
       "", 1, no_tools},
      {"no_json_in_any_form", in_turn({says("It weighs 700 g.")}), "no JSON object", 3, no_tools},
      {"oversize_body", in_turn({oversize}), "larger than", 1, no_tools},
      {"oversize_stream",
       [](const SeenRequest&, int) {
         Reply reply = streams({}, false);
         reply.body.append(5 << 20, ':');
         return reply;
       },
       "larger than", 1, streaming},
      {"wrong_content_type", in_turn({plain(200, "<html>Log in to the WiFi</html>", "text/html")}),
       "OPENAI_BASE_URL", 1, no_tools},
      {"json_under_another_type",
       [](const SeenRequest&, int) {
         Reply reply = says(sound_answer());
         reply.content_type = "text/plain";
         return reply;
       },
       "", 1, no_tools},
      {"invalid_utf8", in_turn({bad_utf8}), "not JSON", 1, no_tools},
      {"deep_nesting_of_the_reply", in_turn({plain(200, deep)}), "nested deeper", 1, no_tools},
      {"deep_nesting_of_the_content", in_turn({says("{\"a\":" + deep)}), "no JSON object", 3, no_tools},
      {"an_array_for_a_reply", in_turn({plain(200, "[1,2,3]")}), "not a JSON object", 1, no_tools},
      {"an_empty_body", in_turn({plain(200, "")}), "not JSON", 1, no_tools},
      {"a_million_open_braces", in_turn({says(std::string(1000000, '{'))}), "no JSON object", 3, no_tools},
      {"the_key_in_the_answer",
       in_turn({says(answer.substr(0, answer.size() - 1) + R"(,"leak":")" + kTestKey + "\"}")}), "", 1,
       no_tools},
      {"usage_of_nonsense",
       in_turn({plain(200,
                      Json{{"choices", {{{"message", {{"content", answer}}}, {"finish_reason", "stop"}}}},
                           {"usage", {{"prompt_tokens", -5}, {"completion_tokens", "many"}, {"cost", 1e300}}}}
                          .dump())}),
       "", 1, no_tools,
       [](const Posts&, const RawAnswer& raw) {
         EXPECT_EQ(raw.prompt_tokens + raw.completion_tokens, 0);
         EXPECT_EQ(raw.cost_usd, 0);
       }},
      {"cost_as_told",
       in_turn(
           {plain(200, Json{{"choices", {{{"message", {{"content", answer}}}, {"finish_reason", "stop"}}}},
                            {"usage", {{"prompt_tokens", 10}, {"completion_tokens", 5}, {"cost", 0.25}}}}
                           .dump())}),
       "", 1, no_tools, [](const Posts&, const RawAnswer& raw) { EXPECT_EQ(raw.cost_usd, 0.25); }},
      {"cost_by_price", in_turn({says(answer)}), "", 1,
       [](Settings& settings) {
         no_tools(settings);
         settings.usd_per_million_prompt_tokens = 2;
         settings.usd_per_million_completion_tokens = 10;
       },
       [](const Posts&, const RawAnswer& raw) {
         EXPECT_NEAR(raw.cost_usd, 1500 * 2e-6 + 200 * 10e-6, 1e-12);
       }},
  };
}

std::vector<EndpointCase> stream_cases() {
  const std::string answer = sound_answer();
  const Reply whole = streams(streamed_answer(answer));
  Reply bytes = whole, windows = whole;
  bytes.piece_bytes = 61;
  for (std::size_t at = 0; (at = windows.body.find('\n', at)) != std::string::npos; at += 2)
    windows.body.replace(at, 1, "\r\n");
  std::vector<std::string> parts = streamed_answer(answer);
  std::vector<std::string> broken(parts.begin(), parts.begin() + 4);
  std::vector<std::string> failing = broken;
  failing.push_back(R"({"error":{"message":"model runner has crashed"}})");
  const std::vector<std::string> tool_parts = {
      R"({"choices":[{"delta":{"tool_calls":[{"index":0,"id":"a","function":{"name":"shell_mass","arguments":""}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":1,"id":"b","function":{"name":"mesh_facts","arguments":"{"}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":0,"function":{"arguments":"{\"area_m2\":2,\"thickness"}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":1,"function":{"arguments":"}"}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":0,"function":{"arguments":"_mm\":1,\"density_kg_m3\":1000}"}}]}}]})",
      R"({"choices":[{"delta":{},"finish_reason":"tool_calls"}]})"};
  return {
      {"stream", in_turn({whole}), "", 1, streaming,
       [](const Posts& posts, const RawAnswer& raw) {
         EXPECT_EQ(body_of(posts[0])["stream_options"]["include_usage"], true);
         EXPECT_EQ(raw.prompt_tokens, 1500);
         EXPECT_EQ(raw.model, "test-model-2026");
       }},
      {"stream_in_small_pieces", in_turn({bytes}), "", 1, streaming},
      {"stream_with_crlf", in_turn({windows}), "", 1, streaming},
      {"stream_with_an_error_in_the_middle", in_turn({streams(failing), whole}), "", 2, streaming},
      {"stream_that_breaks_off", in_turn({streams(broken, false), whole}), "", 2, streaming},
      {"stream_that_stays_open_after_its_end",
       [](const SeenRequest&, int) {
         Reply reply = streams(streamed_answer(sound_answer()));
         reply.hang = true;
         return reply;
       },
       "", 1, streaming},
      {"stream_of_no_json", in_turn({streams({"{\"choices\": [", "x"}), whole}), "", 2, streaming},
      {"stream_asked_for_plain_given", in_turn({says(answer)}), "", 1, streaming},
      {"stream_given_unasked", in_turn({whole}), "", 1, no_tools},
      {"stream_refused", refuses("stream", {{"message", "streaming is not supported"}}), "", 2, streaming},
      {"stream_options_refused",
       refuses("stream_options", {{"message", "Unknown parameter: stream_options"}}), "", 2, streaming},
      {"tool_calls_in_a_stream", in_turn({streams(tool_parts), whole}), "", 2,
       [](Settings& settings) {
         streaming(settings);
         settings.tools = true;
       },
       [](const Posts& posts, const RawAnswer&) { EXPECT_EQ(tool_result(posts), R"({"mass_g":2000.0})"); }},
  };
}

}  // namespace

EndpointSettings test_settings(const std::string& base_url) {
  EndpointSettings settings;
  settings.base_url = base_url;
  settings.model = "test-model";
  settings.api_key = Secret(kTestKey);
  settings.deadline_s = 20;
  settings.connect_timeout_s = 2;
  settings.probe_timeout_s = 2;
  settings.backoff_s = 0.002;
  settings.max_backoff_s = 0.01;
  settings.jitter_seed = 7;
  settings.requests_per_s = 1000;
  settings.request_burst = 1000;
  settings.breaker_failures = 100;
  settings.max_answer_tokens = 2000;
  return settings;
}

const std::vector<EndpointCase>& endpoint_cases() {
  static const std::vector<EndpointCase> all = [] {
    std::vector<EndpointCase> cases;
    for (auto group : {dialect_cases, tool_cases, refusal_cases, busy_cases, content_cases, stream_cases}) {
      for (EndpointCase& one : group()) cases.push_back(std::move(one));
    }
    return cases;
  }();
  return all;
}

}  // namespace livegs

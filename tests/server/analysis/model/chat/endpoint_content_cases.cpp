// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "server/analysis/model/chat/endpoint_case_groups.h"

namespace livegs {

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
  // A reasoning model whose server puts the whole reply into its thoughts.
  const auto thinks = [&](const char* field, const Json& content, const std::string& thoughts) {
    return plain(200,
                 Json{{"choices",
                       {{{"message", {{"content", content}, {field, thoughts}}}, {"finish_reason", "stop"}}}}}
                     .dump());
  };
  return {
      {"answer_in_reasoning", in_turn({thinks("reasoning", "", "It is a cup. " + answer)}), "", 1, no_tools},
      {"answer_in_reasoning_content", in_turn({thinks("reasoning_content", nullptr, answer)}), "", 1,
       no_tools},
      {"thoughts_beside_the_answer", in_turn({thinks("reasoning", answer, "{\"mass_g\":1}")}), "", 1,
       no_tools},
      {"thoughts_without_an_answer", in_turn({thinks("reasoning", "", "It may be a cup.")}), "empty answer",
       -1, no_tools},
      {"address_without_a_path", in_turn({says(answer)}), "", 1,
       [](Settings& settings) {
         no_tools(settings);
         settings.base_url.resize(settings.base_url.rfind("/v1"));
       }},
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
      {"cost_as_reported",
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
  Reply pieces = whole, bytes = whole, windows = whole;
  pieces.piece_bytes = 61;
  bytes.piece_bytes = 1;
  for (std::size_t at = 0; (at = windows.body.find('\n', at)) != std::string::npos; at += 2)
    windows.body.replace(at, 1, "\r\n");
  std::vector<std::string> parts = streamed_answer(answer);
  std::vector<std::string> broken(parts.begin(), parts.begin() + 4);
  std::vector<std::string> failing = broken;
  failing.push_back(R"({"error":{"message":"model runner has crashed"}})");
  const std::vector<std::string> tool_parts = {
      R"({"choices":[{"delta":{"tool_calls":[{"index":0,"id":"a","function":{"name":"shell_mass","arguments":""}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":1,"id":"b","function":{"name":"kb_get","arguments":"{\"id\":\"copper\""}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":0,"function":{"arguments":"{\"area_m2\":2,\"thickness"}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":1,"function":{"arguments":"}"}}]}}]})",
      R"({"choices":[{"delta":{"tool_calls":[{"index":0,"function":{"arguments":"_mm\":1,\"density_kg_m3\":1000}"}}]}}]})",
      R"({"choices":[{"delta":{},"finish_reason":"tool_calls"}]})"};
  std::vector<std::string> thoughts = parts;
  for (std::string& event : thoughts) {
    if (const size_t at = event.find("\"content\""); at != std::string::npos)
      event.replace(at, 9, "\"reasoning\"");
  }
  return {
      {"stream_of_reasoning", in_turn({streams(thoughts)}), "", 1, streaming},
      {"stream", in_turn({whole}), "", 1, streaming,
       [](const Posts& posts, const RawAnswer& raw) {
         EXPECT_EQ(body_of(posts[0])["stream_options"]["include_usage"], true);
         EXPECT_EQ(raw.prompt_tokens, 1500);
         EXPECT_EQ(raw.model, "test-model-2026");
       }},
      {"stream_in_small_pieces", in_turn({pieces}), "", 1, streaming},
      {"stream_of_single_bytes", in_turn({bytes}), "", 1, streaming,
       [](const Posts&, const RawAnswer& raw) { EXPECT_EQ(raw.prompt_tokens, 1500); }},
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

}  // namespace livegs

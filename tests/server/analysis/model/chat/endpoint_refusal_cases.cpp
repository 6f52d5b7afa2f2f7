// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "server/analysis/model/chat/endpoint_case_groups.h"

namespace livegs {

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
         EXPECT_NE(last_text(posts[1]).find("JSON"), std::string::npos);  // OpenAI requires the word
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
      {"429_past_the_deadline", in_turn({with_header(busy, "Retry-After: 3600")}), "exceed the deadline", 1,
       no_tools},
      {"429_for_ever", in_turn({busy}), "limits the request rate", 4, no_tools},
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
      {"connection_refused", in_turn({says(sound_answer())}), "start the server", 0,
       [](Settings& settings) { settings.base_url = "http://127.0.0.1:9/v1"; }},
      {"no_such_host", in_turn({says(sound_answer())}), "start the server", 0,
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

}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "server/analysis/model/chat/endpoint_case_groups.h"

namespace livegs {

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
         // The schema is given in words if it cannot be part of the request.
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
  std::vector<Reply> endless(20, calls({{"kb_get", R"({"id":"copper"})"}}));
  std::vector<std::pair<std::string, std::string>> many(12, {"kb_get", R"({"id":"copper"})"});
  return {
      {"a_tool_then_the_answer",
       one_call("shell_mass", R"({"area_m2":1,"thickness_mm":1,"density_kg_m3":1000})"),
       "",
       2,
       {},
       [](const Posts& posts, const RawAnswer&) { EXPECT_EQ(tool_result(posts), R"({"mass_g":1000.0})"); }},
      {"parallel_tools_are_all_answered",
       in_turn({calls({{"kb_get", R"({"id":"copper"})"},
                       {"material_search", R"({"query":"brass","k":1})"},
                       {"kb_get", R"({"id":"brass"})"}}),
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
         // The returned history is valid nevertheless.
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
         if (index == 0) return calls({{"kb_get", R"({"id":"copper"})"}});
         return request.body.find("\"role\":\"tool\"") != std::string::npos &&
                        !body_of(request).contains("tools")
                    ? fails(400, {{"message", "messages with role tool need tools"}})
                : index == 1 ? calls({{"kb_get", R"({"id":"copper"})"}})
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

}  // namespace livegs

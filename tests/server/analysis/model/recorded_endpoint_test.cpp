// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "analysis/model/model_endpoint.h"
#include "geometry/surface/shape_mesh.h"
#include "scratch_folder.h"
#include "server/analysis/model/chat/model_endpoint_cases.h"

namespace livegs {
namespace {

ToolBox block_tools() {
  ObjectFacts facts;
  facts.name = "block";
  facts.mesh = mesh_facts(box_mesh({0.2, 0.1, 0.1}));
  return ToolBox(facts);
}

AnalysisQuestion block_question() { return {{{"name", "block"}}, {{"scene", "image/png", "\x89PNG one"}}}; }

void expect_same(const RawAnswer& a, const RawAnswer& b) {
  EXPECT_EQ(a.json, b.json);
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.prompt_version, b.prompt_version);
  EXPECT_EQ(a.prompt_tokens, b.prompt_tokens);
  EXPECT_EQ(a.completion_tokens, b.completion_tokens);
  EXPECT_EQ(a.cost_usd, b.cost_usd);  // bitwise equal
  EXPECT_EQ(a.wall_s, b.wall_s);
  EXPECT_EQ(a.transcript, b.transcript);
  EXPECT_EQ(a.warnings, b.warnings);
}

TEST(RecordedEndpoint, ReplaysBitwiseWithoutRequests) {
  const ScratchFolder scratch;
  TestHttpServer server(openai_server());
  RawAnswer asked, repaired;
  {
    EndpointSettings settings = test_settings(server.base_url());
    settings.usd_per_million_prompt_tokens = 0.3;
    auto live = open_model_endpoint(std::move(settings));
    ASSERT_TRUE(live);
    auto recorder = open_recorded_endpoint(scratch / "answers", std::move(*live));
    ASSERT_TRUE(recorder) << recorder.error().message;
    const auto exchange = (*recorder)->start(block_tools());
    const auto first = exchange->ask(block_question(), {});
    ASSERT_TRUE(first) << first.error().message;
    asked = *first;
    const auto second = exchange->repair("mass_g: too heavy", {});
    ASSERT_TRUE(second) << second.error().message;
    repaired = *second;
  }
  const std::size_t posts = server.posts().size();
  auto replay = open_recorded_endpoint(scratch / "answers", nullptr);
  ASSERT_TRUE(replay) << replay.error().message;
  EXPECT_EQ((*replay)->state().model, "test-model");
  for (int run = 0; run < 2; ++run) {
    const auto exchange = (*replay)->start(block_tools());
    const auto first = exchange->ask(block_question(), {});
    ASSERT_TRUE(first) << first.error().message;
    expect_same(*first, asked);
    const auto second = exchange->repair("mass_g: too heavy", {});
    ASSERT_TRUE(second) << second.error().message;
    expect_same(*second, repaired);
  }
  EXPECT_EQ(server.posts().size(), posts);
  for (const auto& file : std::filesystem::directory_iterator(scratch / "answers")) {
    std::ostringstream text;
    text << std::ifstream(file.path()).rdbuf();
    const std::string key = kTestKey;
    for (std::size_t at = 0; at + 8 <= key.size(); ++at) {
      ASSERT_EQ(text.str().find(key.substr(at, 8)), std::string::npos) << file.path();
    }
  }
}

TEST(RecordedEndpoint, UnrecordedQuestionIsAnError) {
  const ScratchFolder scratch;
  const auto nothing = open_recorded_endpoint(scratch / "absent", nullptr);
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().message.find("record them first"), std::string::npos);
  scratch.write("answers/endpoint.json", R"({"format":"livegs.recording/1","model":"m"})");
  const auto replay = open_recorded_endpoint(scratch / "answers", nullptr);
  ASSERT_TRUE(replay);
  const auto answer = (*replay)->start(block_tools())->ask(block_question(), {});
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::NotFound);
  EXPECT_NE(answer.error().message.find("\"block\""), std::string::npos) << answer.error().message;
}

TEST(RecordedEndpoint, AnyChangeOfTheQuestionChangesItsKey) {
  const ScratchFolder scratch;
  TestHttpServer server(in_turn({says(sound_answer())}));
  auto live = open_model_endpoint(test_settings(server.base_url()));
  ASSERT_TRUE(live);
  auto recorder = open_recorded_endpoint(scratch / "answers", std::move(*live));
  ASSERT_TRUE(recorder);
  const auto ask = [&](const AnalysisQuestion& question) {
    ASSERT_TRUE((*recorder)->start(block_tools())->ask(question, {}));
  };
  AnalysisQuestion question = block_question();
  ask(question);
  ask(question);
  EXPECT_EQ(server.posts().size(), 1u);
  question.images[0].bytes += "x";
  ask(question);
  EXPECT_EQ(server.posts().size(), 2u);
  question.slots["size"] = "0.2 m";
  ask(question);
  EXPECT_EQ(server.posts().size(), 3u);
  // Another prompt has another version.
  scratch.write("prompts/system.md", "Say what it weighs.\n");
  auto other_live = open_model_endpoint(test_settings(server.base_url()));
  auto other = open_recorded_endpoint(scratch / "answers", std::move(*other_live), scratch / "prompts");
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_TRUE((*other)->start(block_tools())->ask(question, {}));
  EXPECT_EQ(server.posts().size(), 4u);
}

TEST(RecordedEndpoint, DamagedRecordingIsAnError) {
  const ScratchFolder scratch;
  TestHttpServer server(in_turn({says(sound_answer())}));
  auto live = open_model_endpoint(test_settings(server.base_url()));
  auto recorder = open_recorded_endpoint(scratch / "answers", std::move(*live));
  ASSERT_TRUE(recorder);
  ASSERT_TRUE((*recorder)->start(block_tools())->ask(block_question(), {}));
  for (const auto& file : std::filesystem::directory_iterator(scratch / "answers")) {
    if (file.path().filename() != "endpoint.json") std::ofstream(file.path()) << "{\"format\":";
  }
  const auto answer = (*recorder)->start(block_tools())->ask(block_question(), {});
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("record it again"), std::string::npos) << answer.error().message;
}

}  // namespace
}  // namespace livegs

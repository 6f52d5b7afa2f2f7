// SPDX-License-Identifier: Apache-2.0
// `livegs analyze --record` and `--recorded` as whole programs, against a server that the test makes up: what
// is kept beside the assets is the same to the byte, whenever and wherever the answers are replayed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "gaussian/asset_file.h"
#include "geometry/shape_mesh.h"
#include "scene/shape_asset.h"
#include "scratch_folder.h"
#include "server/analysis/model_endpoint_cases.h"
#include "system/program.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "cup", "asset": "cup.ply", "scale": 1, "pose": { "position_m": [0, 0.05, 0] } },
    { "name": "duck", "asset": "duck.ply", "scale": 1, "pose": { "position_m": [0.3, 0.05, 0] } } ] })";

// A cup of 310 g; a duck of 95 g, whose first answer is out of order and has to be asked for again.
Reply made_up_answer(const SeenRequest& request, int) {
  const bool duck = request.body.find(R"(\"duck\")") != std::string::npos;
  const bool repaired = body_of(request)["messages"].size() > 2;
  const double best_g = duck ? 95 : 310;
  Json answer = Json::parse(sound_answer());
  answer["name"] = duck ? "rubber duck" : "cup";
  answer["fill"] = duck ? "shell" : "open_shell";
  answer["parts"] = {{{"name", "body"},
                      {"material_id", duck ? "flexible PVC" : "stoneware"},
                      {"share", 1.0},
                      {"thickness_mm", duck ? 3.0 : 4.0}}};
  answer["behaviour"] = duck ? "elastic" : "rigid";
  answer["fragile"] = !duck;
  for (const char* field : {"young_mpa", "structure_s", "plasticity_level", "plasticity"})
    answer[field] = nullptr;
  answer["mass_g"] = {{"low", 0.8 * best_g}, {"best", best_g}, {"high", 1.25 * best_g}};
  if (duck && !repaired) answer["mass_g"]["high"] = 0.5 * best_g;
  return says(answer.dump());
}

struct Said {
  int code;
  std::string out, err;
};
Said analyze(const fs::path& folder, std::vector<std::string> more) {
  std::vector<std::string> words = {LIVEGS_TOOL, "analyze", folder / "two.scene.json", "--json", "--write"};
  words.insert(words.end(), more.begin(), more.end());
  Program program(words);
  const int code = program.wait();
  return {code, program.out(), program.err()};
}

std::string bytes_of(const fs::path& path) {
  auto text = read_text_file(path, 1 << 24);
  EXPECT_TRUE(text) << text.error().message;
  return text ? *text : "";
}

TEST(AnalyzeReplay, GivesTheSameBytesEveryTimeAndAsksNobody) {
  const ScratchFolder scratch;
  ::setenv("XDG_CACHE_HOME", (scratch / "cache").c_str(), 1);
  for (const char* name : {"OPENAI_BASE_URL", "OPENAI_API_KEY", "LIVEGS_MODEL"}) ::unsetenv(name);
  const GaussianAsset clay = mesh_asset(sphere_mesh(0.05, 3), {0.8f, 0.7f, 0.6f}, 2000);
  const GaussianAsset rubber = mesh_asset(box_mesh({0.1, 0.08, 0.1}), {0.9f, 0.8f, 0.1f}, 2000);
  const std::string answers = scratch / "answers";
  for (const char* name : {"live", "first", "second"}) {
    scratch.write(std::string(name) + "/two.scene.json", kScene);
    ASSERT_TRUE(write_asset(scratch.path() / name / "cup.ply", clay));
    ASSERT_TRUE(write_asset(scratch.path() / name / "duck.ply", rubber));
  }

  Said live;
  {
    TestModelServer server(made_up_answer);
    live = analyze(scratch / "live",
                   {"--endpoint", server.base_url(), "--model", "made-up", "--record", answers});
    EXPECT_EQ(server.posts().size(), 3u);  // and one repair
  }
  ASSERT_EQ(live.code, 0) << live.err;
  EXPECT_NE(live.err.find("duck: would not do, asked again"), std::string::npos) << live.err;

  const Said first = analyze(scratch / "first", {"--recorded", answers});
  const Said second = analyze(scratch / "second", {"--recorded", answers});
  ASSERT_EQ(first.code, 0) << first.err;
  ASSERT_EQ(second.code, 0) << second.err;
  EXPECT_EQ(first.out, second.out);
  EXPECT_EQ(first.out, live.out);
  const auto told = nlohmann::json::parse(first.out);
  for (const auto& object : told["objects"]) {
    EXPECT_EQ(object["verdict"], "accepted") << object["message"];
    EXPECT_EQ(object["model"], "test-model-2026");
  }
  for (const char* name : {"cup.physics.json", "cup.physics.log", "duck.physics.json", "duck.physics.log"}) {
    const std::string kept = bytes_of(scratch.path() / "first" / name);
    EXPECT_NE(kept.find("test-model-2026"), std::string::npos) << name;
    EXPECT_EQ(kept, bytes_of(scratch.path() / "second" / name)) << name;
  }
}

// A folder in which something is missing is told by the object's name, and the estimates stand.
TEST(AnalyzeReplay, WhatWasNeverAskedIsToldInOneLine) {
  const ScratchFolder scratch;
  const std::string csv = "x,y,z\n0,0,0\n0.02,0,0\n0,0.02,0\n0,0,0.02\n";
  scratch.write("points.csv", csv);
  scratch.write("two.scene.json", R"({ "objects": [ { "name": "grains", "points": "points.csv",
    "kernel_per_point": true } ] })");
  scratch.write("answers/endpoint.json", R"({"format":"livegs.recording/1","model":"made-up"})");
  const Said said = analyze(scratch.path(), {"--recorded", scratch / "answers"});
  EXPECT_EQ(said.code, 1);
  EXPECT_NE(said.err.find("grains"), std::string::npos) << said.err;
  EXPECT_NE(said.err.find("record it with an endpoint set"), std::string::npos) << said.err;
  EXPECT_NE(said.out.find("\"verdict\": \"offline\""), std::string::npos) << said.out;
}

}  // namespace
}  // namespace livegs

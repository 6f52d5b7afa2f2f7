// SPDX-License-Identifier: Apache-2.0
// Judgement of prompt changes. All answers are synthetic; no model is used.
#include "server/analysis/model/prompt_trial.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "analysis/model/prompt_set.h"
#include "core/file.h"
#include "geometry/surface/shape_mesh.h"
#include "scratch_folder.h"
#include "server/analysis/model/chat/model_endpoint_cases.h"
#include "server/analysis/model/prompt_judgement.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;

const fs::path kPrompts = fs::path(LIVEGS_TESTS_DIR) / "../prompts";

// Twelve objects with masses of about twice the estimate.
std::vector<JudgedObject> things() {
  std::vector<JudgedObject> objects;
  for (const char* name : {"mug", "wooden block", "hammer", "sponge", "tennis ball", "book", "bowl", "plate",
                           "spoon", "brick", "candle", "cup"}) {
    ObjectFacts facts;
    facts.name = name;
    facts.scale_known = true;
    facts.mesh =
        mesh_facts(box_mesh(Eigen::Vector3d::Constant(0.08 + 0.005 * static_cast<double>(objects.size()))));
    JudgedObject object;
    object.id = name;
    object.target.object_id = static_cast<uint32_t>(objects.size() + 1);
    object.target.facts = std::make_shared<ObjectFacts>(facts);
    object.target.offline = estimate_offline(facts);
    object.mass_kg =
        object.target.offline.mass_kg().best() * (1.5 + 0.1 * static_cast<double>(objects.size()));
    object.behavior = object.target.offline.behavior();
    objects.push_back(std::move(object));
  }
  return objects;
}

Result<std::vector<TargetView>> look(uint32_t object_id, int, std::stop_token) {
  return std::vector<TargetView>{
      {{{"scene", "image/png", "\x89PNG " + std::to_string(object_id)}}, "from the front"}};
}

// Synthetic model: returns the true mass if the system text contains "care", an unordered range for "haste",
// and the estimate from the prompt otherwise.
TestHttpServer::Handler made_up_model(const std::vector<JudgedObject>& objects) {
  return [&objects](const SeenRequest& request, int) {
    const auto asks_for = [&](const char* word) { return request.body.find(word) != std::string::npos; };
    for (const JudgedObject& object : objects) {
      if (!asks_for(("file: \\\"" + object.id + "\\\"").c_str())) continue;
      const double best_g =
          1000 * (asks_for("Take care.") ? object.mass_kg : object.target.offline.mass_kg().best());
      Json answer = Json::parse(sound_answer());
      answer["behaviour"] = object.behavior == v1::Physics::ELASTIC ? "elastic" : "rigid";
      answer["parts"] = {{{"name", "all"},
                          {"material_id", object.target.offline.material()},
                          {"share", 1.0},
                          {"thickness_mm", nullptr}}};
      for (const char* field : {"young_mpa", "structure_s", "plasticity_level", "plasticity"})
        answer[field] = nullptr;
      answer["fragile"] = object.target.offline.fragile();
      answer["mass_g"] = {{"low", 0.9 * best_g}, {"best", best_g}, {"high", 1.1 * best_g}};
      if (asks_for("Make haste.")) answer["mass_g"]["low"] = 2 * best_g;
      Reply reply = says(answer.dump());
      Json body = Json::parse(reply.body);
      body["model"] = "made-up-1";
      reply.body = body.dump();
      return reply;
    }
    return not_found_reply();
  };
}

// A copy of prompts/ with one more sentence in the system text and a new version.
fs::path changed_prompts(const ScratchFolder& scratch, const std::string& name, const std::string& sentence,
                         const char* version = "7") {
  const fs::path folder = scratch / name;
  fs::copy(kPrompts, folder);
  std::ofstream(folder / "system.md", std::ios::app) << sentence << '\n';
  std::ofstream(folder / "version.txt") << version << '\n';
  return folder;
}

std::unique_ptr<ModelEndpoint> open(const TestHttpServer* server, const fs::path& answers,
                                    const fs::path& prompts) {
  std::unique_ptr<ModelEndpoint> live;
  if (server) {
    EndpointSettings settings = test_settings(server->base_url());
    settings.prompt_folder = prompts;
    live = std::move(*open_model_endpoint(std::move(settings)));
  }
  auto endpoint = open_recorded_endpoint(answers, std::move(live), prompts);
  EXPECT_TRUE(endpoint) << endpoint.error().message;
  return std::move(*endpoint);
}

const PromptMeasure& row(const PromptComparison& comparison, const std::string& name) {
  for (const PromptMeasure& measure : comparison.measures) {
    if (measure.name == name) return measure;
  }
  ADD_FAILURE() << name;
  return comparison.measures.front();
}

TEST(PromptTrial, FindsTheBetterPromptsLiveAndInReplay) {
  const ScratchFolder scratch;
  const auto objects = things();
  const fs::path careful = changed_prompts(scratch, "careful", "Take care.");
  const fs::path hasty = changed_prompts(scratch, "hasty", "Make haste.");
  const auto trial = [&](const TestHttpServer* server, const fs::path& prompts) {
    auto done = try_prompts(objects, *open(server, scratch / "answers", prompts), look);
    EXPECT_TRUE(done) << done.error().message;
    return done ? *done : PromptTrial{};
  };
  PromptTrial plain, better, refused;
  {
    TestHttpServer server(made_up_model(objects));
    plain = trial(&server, kPrompts);
    better = trial(&server, careful);
    refused = trial(&server, hasty);
  }
  ASSERT_EQ(better.outcomes.size(), objects.size());
  EXPECT_EQ(better.model, "made-up-1");
  EXPECT_NE(plain.prompt_version, better.prompt_version);

  const PromptComparison up = compare_prompts(plain, better);
  EXPECT_EQ(up.verdict, PromptVerdict::Better);
  EXPECT_LT(row(up, "mape").after, row(up, "mape").before);
  EXPECT_GT(row(up, "mnre").after, row(up, "mnre").before);
  EXPECT_EQ(compare_prompts(better, plain).verdict, PromptVerdict::Worse);
  EXPECT_EQ(compare_prompts(plain, plain).verdict, PromptVerdict::Same);
  // A refused answer leaves the estimate, so masses are unchanged; the refusal counts separately.
  const PromptComparison down = compare_prompts(plain, refused);
  EXPECT_EQ(row(down, "refused").after, 1.0);
  EXPECT_EQ(row(down, "repaired").after, 1.0);
  EXPECT_EQ(down.verdict, PromptVerdict::Worse);

  // Replays only, without an endpoint.
  const PromptTrial again = trial(nullptr, careful);
  for (size_t i = 0; i < objects.size(); ++i) {
    EXPECT_EQ(again.outcomes[i].mass.best_kg, better.outcomes[i].mass.best_kg);  // bitwise equal
    EXPECT_EQ(again.outcomes[i].mass.high_kg, better.outcomes[i].mass.high_kg);
  }
  EXPECT_EQ(again.prompt_tokens, better.prompt_tokens);
  const auto unknown = try_prompts(
      objects, *open(nullptr, scratch / "answers", changed_prompts(scratch, "new", "Be brief.")), look);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("mug: "), std::string::npos) << unknown.error().message;
}

// One changed object of twelve is not evidence: the interval of the mean contains 0 unless most agree.
TEST(PromptTrial, ChanceIsNotAnImprovement) {
  PromptTrial before;
  for (int i = 0; i < 12; ++i)
    before.outcomes.push_back({{"", 1.0, 0.8, 1.1, 1.3}, true, false, false, false});
  PromptTrial after = before;
  after.outcomes[3].mass.best_kg = 1.0;
  after.outcomes[7].refused = true;
  EXPECT_EQ(compare_prompts(before, after).verdict, PromptVerdict::Same);
  for (PromptOutcome& outcome : after.outcomes) outcome.mass.high_kg = 0.95;  // ranges that exclude the truth
  EXPECT_EQ(compare_prompts(before, after).verdict, PromptVerdict::Worse);
  PromptTrial narrow = before;
  for (PromptOutcome& outcome : narrow.outcomes) outcome.mass.high_kg = 0.95;
  EXPECT_EQ(compare_prompts(narrow, before).verdict,
            PromptVerdict::Same);  // a wider range alone is not better
}

// Checks the prompts of this repository.
TEST(PromptJudgement, PromptsMatchTheirJudgement) {
  const auto checked = check_judgement(kPrompts);
  EXPECT_TRUE(checked) << checked.error().message;
}

// Earlier tokens influence later ones: the range precedes the value (prompts/system.md, step 8).
TEST(Prompts, RangePrecedesTheValue) {
  const std::vector<std::string> order = {"low", "high", "best"};
  const auto keys = [](const nlohmann::ordered_json& range) {
    std::vector<std::string> names;
    for (const auto& [name, value] : range.items()) names.push_back(name);
    return names;
  };
  const auto json = [](const char* name) {
    return nlohmann::ordered_json::parse(*read_text_file(kPrompts / name));
  };
  const auto fields = json("answer.schema.json")["properties"];
  const auto& young = fields["young_mpa"]["anyOf"][0];
  for (const auto& range : {fields["mass_g"], young}) {
    EXPECT_EQ(range["required"], nlohmann::ordered_json(order));
    EXPECT_EQ(keys(range["properties"]), order);
  }
  for (const auto& example : json("examples.json")) {
    EXPECT_EQ(keys(example["answer"]["mass_g"]), order) << example["facts"];
    const auto& answered = example["answer"]["young_mpa"];
    if (!answered.is_null()) EXPECT_EQ(keys(answered), order) << example["facts"];
  }
}

// All texts are files: those of a folder replace the built-in ones, also for captions and facts.
TEST(Prompts, CaptionsAndFactsComeFromFiles) {
  const ScratchFolder scratch;
  scratch.write("prompts/captions.json", R"({ "outlined": "look here" })");
  scratch.write("prompts/user.md", "Name: {{name}}\nOff by {{scale_off}}\n");
  const auto built_in = PromptSet::load(""), own = PromptSet::load(scratch / "prompts");
  ASSERT_TRUE(built_in && own);
  EXPECT_NE(built_in->version(), own->version());
  EXPECT_EQ(built_in->caption("outlined"), "the object outlined in the scene");
  EXPECT_EQ(own->caption("outlined"), "look here");
  EXPECT_EQ(own->caption("mask"), "mask");
  EXPECT_EQ(own->user({{"name", "cup"}, {"scale_off", "2"}}), "Name: \"cup\"\nOff by 2\n");
  EXPECT_EQ(own->user({{"name", "cup"}}), "Name: \"cup\"\n");
  scratch.write("prompts/captions.json", "[");
  EXPECT_FALSE(PromptSet::load(scratch / "prompts"));
}

TEST(PromptJudgement, ChangedPromptRequiresAJudgement) {
  const ScratchFolder scratch;
  const auto refusal = [](const fs::path& folder) {
    const auto checked = check_judgement(folder);
    EXPECT_FALSE(checked);
    const std::string message = checked ? "" : checked.error().message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_NE(message.find("mass_harness --judge"), std::string::npos) << message;
    return message;
  };
  EXPECT_NE(refusal(changed_prompts(scratch, "same number", "Take care.", "6")).find("increase it"),
            std::string::npos);
  EXPECT_NE(refusal(changed_prompts(scratch, "number raised", "Take care.")).find("is for version 6"),
            std::string::npos);

  // With measurements it passes, unless they are worse or synthetic.
  const fs::path folder = changed_prompts(scratch, "judged", "Take care.");
  PromptTrial before;
  before.model = "some-model";
  for (int i = 0; i < 12; ++i)
    before.outcomes.push_back({{"", 1.0, 0.5, 1.5, 2.0}, true, false, false, false});
  PromptTrial after = before;
  for (PromptOutcome& outcome : after.outcomes) outcome.mass.best_kg = 1.1;
  const auto keep = [&](const PromptTrial& first, const PromptTrial& second) {
    const auto text = judgement_text(kPrompts, folder, first, second, "none");
    ASSERT_TRUE(text) << text.error().message;
    std::ofstream(folder / "judged.json") << *text;
  };
  keep(before, after);
  EXPECT_TRUE(check_judgement(folder)) << check_judgement(folder).error().message;
  keep(after, before);
  EXPECT_NE(refusal(folder).find("worse than the previous"), std::string::npos);
  after.model = before.model = "made-up-1";
  const auto made_up = judgement_text(kPrompts, folder, before, after, "none");
  ASSERT_FALSE(made_up);
  EXPECT_NE(made_up.error().message.find("answers are synthetic"), std::string::npos);
}

}  // namespace
}  // namespace livegs

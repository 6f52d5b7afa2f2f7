// SPDX-License-Identifier: Apache-2.0
#include "analysis/text/message_templates.h"

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "analysis/gate/answer.h"
#include "analysis/gate/gate.h"
#include "analysis/knowledge/name_match.h"
#include "analysis/knowledge/table_search.h"
#include "analysis/model/fact_slots.h"
#include "analysis/model/model_endpoint.h"
#include "analysis/model/prompt_set.h"
#include "analysis/run/ask_model.h"
#include "core/content_hash.h"
#include "core/file.h"
#include "scratch_folder.h"
#include "server/analysis/gate/answer_fixtures.h"
#include "server/analysis/model/chat/model_endpoint_cases.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
const fs::path kRepository = fs::path(LIVEGS_TESTS_DIR) / "..";

// Every line of the files is used, and every used name exists; an unknown name would be sent literally.
TEST(MessageTemplates, EveryLineIsUsedAndEveryUsedLineExists) {
  std::string code;
  for (const auto& file : fs::recursive_directory_iterator(kRepository / "server/analysis")) {
    if (file.path().extension() == ".cpp") code += *read_text_file(file.path());
  }
  auto lines = MessageTemplates::built_in().lines();
  ASSERT_GT(lines.size(), 60u);
  for (const auto& [name, text] : MessageTemplates::reasons().lines())
    EXPECT_TRUE(lines.emplace(name, text).second) << name;
  const std::regex slot("\\{\\{([a-z_]+)\\}\\}");
  for (const auto& [name, text] : lines) {
    EXPECT_NE(code.find("\"" + name + "\""), std::string::npos) << name;
    for (std::sregex_iterator at(text.begin(), text.end(), slot), end; at != end; ++at)
      EXPECT_NE(code.find("{\"" + (*at)[1].str() + "\", "), std::string::npos) << name << " " << (*at)[1];
  }
  const std::regex said(
      R"re((?:\bsay|\bfail|\bwrong|\brequire)\(\s*(?:"[a-z_]+", (?="form_))?"([a-z_0-9]+)"|"(form_[a-z]+)")re");
  int count = 0;
  for (std::sregex_iterator at(code.begin(), code.end(), said), end; at != end; ++at) {
    const std::string name = (*at)[1].matched ? (*at)[1] : (*at)[2];
    EXPECT_TRUE(lines.contains(name)) << (*at)[0];
    ++count;
  }
  EXPECT_GT(count, 60);
}

// The reasons of a mass reach the model in the line of the offline estimate. prompts/judged.json does not
// cover them, so a change of this hash requires a judgement.
TEST(MessageTemplates, MassReasonsAreUnchanged) {
  const std::string text = *read_text_file(kRepository / "server/analysis/knowledge/mass_reasons.json");
  EXPECT_EQ(content_hash(std::as_bytes(std::span(text))),
            "432807ba3c2dc69f29c9bba26c7e0ac4d88065409d66f37fe10d94c010b15fb9");
  const auto reason = [](const ObjectFacts& facts) { return estimate_offline(facts).mass_kg().reason(); };
  EXPECT_TRUE(std::regex_match(
      reason(mug_facts()), std::regex("mug: [0-9.]+ g usual at this size; [0-9.]+ g = 2200 kg/m3 x 4.5 mm x "
                                      "0.0275 m2 of wall; or [a-z ]+ \\([0-9]+ %\\) [0-9.]+ g; or .*")))
      << reason(mug_facts());
  ObjectFacts unnamed = sponge_facts();
  unnamed.name = "";
  unnamed.scale_known = false;
  EXPECT_TRUE(std::regex_match(
      reason(unnamed), std::regex("like things of its size and shape: [a-z ]+ \\([0-9]+ %\\) [0-9.]+ g, .*; "
                                  "the scale is a guess")))
      << reason(unnamed);
  ObjectFacts solid = pillow_facts();
  solid.name = "wood block";
  solid.solid = true;
  EXPECT_EQ(reason(solid), "500 kg/m3 x 0.011 m3 enclosed");
  v1::Physics written;
  written.set_density_kg_m3(500);
  const auto mass_reason = [&](v1::EstimatedValue::Source by) {
    return merge_scene_physics(estimate_offline(solid), written, solid, by)->mass_kg().reason();
  };
  EXPECT_EQ(mass_reason(v1::EstimatedValue::SCENE),
            "from the scene's density: 500 kg/m3 x 0.011 m3 enclosed");
  EXPECT_EQ(mass_reason(v1::EstimatedValue::PERSON),
            "from a person's density: 500 kg/m3 x 0.011 m3 enclosed");
  written.Clear();
  written.set_mass_kg(3);
  EXPECT_EQ(mass_reason(v1::EstimatedValue::SCENE), "written in the scene");
  EXPECT_EQ(mass_reason(v1::EstimatedValue::PERSON), "edited by a person");
}

// The facts of version 4 of the prompts.
TEST(MessageTemplates, FactsAreUnchanged) {
  ObjectFacts facts = mug_facts();
  facts.mesh.rod = 0.5;
  facts.mesh.piece_count = 2;
  facts.appearance = {{0.2f, 0.5f, 0.9f}, 0.3f, 0.7f, 0.7f, 0.33f};
  v1::PhysicalParameters offline = estimate_offline(facts);
  offline.mutable_friction()->set_source(v1::EstimatedValue::PERSON);
  offline.mutable_friction()->set_best(0.4);
  offline.mutable_mass_kg()->set_low(0.25);
  offline.mutable_mass_kg()->set_best(0.3);
  offline.mutable_mass_kg()->set_high(0.4);
  offline.mutable_mass_kg()->set_source(v1::EstimatedValue::SCENE);
  offline.mutable_mass_kg()->set_reason("as it says");
  offline.set_confidence(0.5);
  const std::vector<SceneObjectFacts> neighbours = {
      {"cup", "", "", 0, {0.1, 0.2, 0.3}, 1.5, true},
      {"a \"pot\"\n", "terracotta", "rigid", 0.7, {0.1, 0.1, 0.1}, 0.5, false}};
  const auto slots = fact_slots(facts, offline, neighbours);
  EXPECT_EQ(slots.at("size"), "smallest box 9.5 x 8 x 8 cm, 9.5 cm high as it stands");
  EXPECT_EQ(slots.at("scale"), "metric");
  EXPECT_EQ(slots.at("mesh"),
            "volume 120 cm3, area 550 cm2, in an open wall both sides (275 cm2 of wall), mean thickness 2V/A "
            "4.4 mm, "
            "25 % of its convex hull, 60 % open, rod, 2 pieces");
  EXPECT_EQ(slots.at("looks"), "mean #3380e6, saturation 0.30, spread of hue 0.70 rad");
  EXPECT_EQ(slots.at("neighbours"), "- \"cup\": 0.1 x 0.2 x 0.3 m, 1.5 m away");
  EXPECT_EQ(slots.at("category"), "mug of stoneware, open_shell, wall 3 to 6.5 mm, rigid");
  EXPECT_EQ(slots.at("told"), "mass_kg 0.3, friction 0.4");
}

// The prior of mass is fused after the answer, so no mass of the tables is sent; a name that the tables do
// not have gets no usual form.
TEST(MessageTemplates, FactsHoldNoMassOfTheTables) {
  for (ObjectFacts facts : {sponge_facts(), mug_facts(), tennis_ball_facts(), pillow_facts()}) {
    for (const char* name : {facts.name.c_str(), "brick", "hammer", "thing01", ""}) {
      facts.name = name;
      const auto slots = fact_slots(facts, estimate_offline(facts), {});
      EXPECT_EQ(slots.contains("category"), match_name(facts.name).row != nullptr) << name;
      for (const auto& [slot, text] : slots) EXPECT_EQ(text.find(" g"), std::string::npos) << text;
    }
  }
}

TEST(KnowledgeSearch, SimilarMaterialIsOfTheSameClass) {
  const auto first = [](const char* name) {
    return similar_materials(material_row(name), 3).front()->material_class;
  };
  for (const char* name :
       {"stoneware", "carbon steel", "soda-lime glass", "polyurethane foam", "softwood", "polypropylene"})
    EXPECT_EQ(first(name), material_row(name).material_class) << name;
  EXPECT_EQ(similar_materials(material_row("carbon steel"), 1).front()->name, "tinplate");  // tinned steel
  EXPECT_EQ(similar_materials(material_row("brass"), 1000).size(), material_table().size() - 1);
}

TEST(MessageTemplates, InsertedValuesAreNotScannedAgain) {
  const MessageTemplates& words = MessageTemplates::built_in();
  EXPECT_EQ(words.say("part_unknown", {{"field", "parts[0]"}, {"told", "{{field}}"}}),
            "parts[0].material_id: \"{{field}}\" is not in the table; give a name from it");
  EXPECT_EQ(words.say("part_unknown", {{"field", "parts[0]"}, {"told", ""}}),
            "parts[0].material_id: \"\" is not in the table; give a name from it");
}

// Braces in the program's own complaints are sent unchanged; a model's text cannot open a slot or end a
// quote.
TEST(MessageTemplates, OnlyOwnBracesReachTheModel) {
  const auto prompts = PromptSet::load({});
  const auto complaint = [&](const nlohmann::json& answer) {
    const auto read = read_answer(answer.dump());
    EXPECT_FALSE(read);
    const std::string turn = read ? "" : prompts->repair(read.error().message);
    return turn.substr(0, turn.find('\n'));
  };
  const std::string found = "A check of your answer found this: ";
  nlohmann::json answer = mug_answer();
  answer["mass_g"] = nullptr;
  EXPECT_EQ(complaint(answer), found + "\"mass_g: is missing; give {low, best, high} in grams\"");
  answer["mass_g"] = nlohmann::json::array({1, 2, 3});
  EXPECT_EQ(complaint(answer), found + "\"mass_g: is a JSON array; give {low, best, high}\"");
  answer["mass_g"] = {{"low", 3}, {"best", 2}, {"high", 4}};
  EXPECT_EQ(complaint(answer),
            found + "\"mass_g: low <= best <= high does not hold; give them in order, in grams\"");
  answer = mug_answer();
  answer["parts"][0]["material_id"] = "{{problem}}\" <b>`ore`\n{low}";
  EXPECT_EQ(
      complaint(answer),
      found +
          "\"parts[0].material_id: '((problem))' (b)'ore' (low)' is not in the table; give a name from it\"");
}

// prompts/FILE with one line replaced.
std::string with_line(const char* file, const char* line, const char* text) {
  auto json = nlohmann::ordered_json::parse(*read_text_file(kRepository / "prompts" / file));
  json.at(line) = text;
  return json.dump(1);
}

TEST(MessageTemplates, FolderTextsAreSentAndChangeTheVersion) {
  const ScratchFolder scratch;
  scratch.write("prompts/facts.json", with_line("facts.json", "size", "LONG {{long}}"));
  scratch.write("prompts/complaints.json",
                with_line("complaints.json", "out_of_order", "SORT {{field}}{{in_unit}}"));
  scratch.write("prompts/tool_words.json", with_line("tool_words.json", "no_row", "NO ROW"));
  nlohmann::json wrong = mug_answer();
  wrong["mass_g"]["low"] = 1000;
  TestHttpServer server(in_turn(
      {calls({{"kb_get", R"({"id":"unobtainium"})"}}), says(wrong.dump()), says(mug_answer().dump())}));
  EndpointSettings settings = test_settings(server.base_url());
  settings.prompt_folder = scratch / "prompts";
  auto endpoint = open_model_endpoint(std::move(settings));
  ASSERT_TRUE(endpoint) << endpoint.error().message;
  AnalysisTarget target;
  target.facts = std::make_shared<const ObjectFacts>(mug_facts());
  target.offline = estimate_offline(*target.facts);
  AnalysisUpdate update;
  const auto look = [](uint32_t, int, std::stop_token) -> Result<std::vector<TargetView>> {
    return std::vector<TargetView>{{{{"outlined", "image/png", "\x89PNG"}}, "from the front"}};
  };
  ask_model(
      target, {}, **endpoint, (*endpoint)->state(), look, {}, [](AnalysisStage) {}, {}, update);
  ASSERT_EQ(update.judgement.verdict, Verdict::Accepted) << update.judgement.message;
  const auto posts = server.posts();
  ASSERT_EQ(posts.size(), 3u);
  EXPECT_NE(posts[0].body.find("LONG 9.5\\n"), std::string::npos) << posts[0].body;
  EXPECT_NE(posts[1].body.find("NO ROW"), std::string::npos);
  EXPECT_NE(posts[2].body.find("SORT mass_g, in grams"), std::string::npos);
  EXPECT_NE(PromptSet::load(scratch / "prompts")->version(), PromptSet::load({})->version());
}

// Error from loading a folder with only this file, without the folder's path.
std::string refusal_of(const char* file, const std::string& text) {
  const ScratchFolder scratch;
  scratch.write(std::string("prompts/") + file, text);
  const auto loaded = PromptSet::load(scratch / "prompts");
  if (loaded) return "";
  const std::string path = (scratch / "prompts" / file).string() + ": ";
  EXPECT_TRUE(loaded.error().message.starts_with(path)) << loaded.error().message;
  EXPECT_EQ(loaded.error().message.find('\n'), std::string::npos) << loaded.error().message;
  return loaded.error().message.substr(std::min(path.size(), loaded.error().message.size()));
}

TEST(MessageTemplates, MissingOrExtraLineIsAnError) {
  const auto refusal = [](const std::string& text) { return refusal_of("complaints.json", text); };
  const std::string whole = *read_text_file(kRepository / "prompts/complaints.json");
  EXPECT_EQ(refusal(whole), "");
  nlohmann::json json = nlohmann::json::parse(whole);
  json.erase("too_wide");
  EXPECT_EQ(refusal(json.dump()), "has no line too_wide; add it, or delete the file to use the built-in one");
  json["too_wide"] = 3;
  EXPECT_EQ(refusal(json.dump()), "too_wide is not a string; write its text in quotes");
  json["too_wide"] = json["to_wide"] = "x";
  EXPECT_EQ(refusal(json.dump()), "to_wide is not a line of this file; remove it");
  EXPECT_EQ(refusal("["), "not a JSON object; correct it, or delete the file to use the built-in one");
}

// Regression: both crashed the program.
TEST(PromptFolder, MalformedFileIsAnError) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_EQ(refusal_of("examples.json", R"({"a": {"facts": "x", "answer": {}}})"),
            "must be a list of examples; correct it, or delete the file to use the built-in one");
  EXPECT_EQ(refusal_of("examples.json", R"([{"facts": "x", "answer": )" + deep + "}]"),
            "nested too deep; correct it, or delete the file to use the built-in one");
  EXPECT_EQ(refusal_of("answer.schema.json",
                       R"({"required": [], "enum": ["{{material_ids}}"], "a": )" + deep + "}"),
            "nested too deep; correct it, or delete the file to use the built-in one");
}

// Regression: these lines were left out, or sent literally, without an error.
TEST(PromptFolder, UnknownSlotIsAnErrorWithARemedy) {
  EXPECT_EQ(refusal_of("user.md", "Name: {{name}}\nSize: {{szie}}\n"),
            "line 2: {{szie}} is not a known slot; write {{size}} or remove it");
  EXPECT_EQ(refusal_of("user.md", "Name: {{name}}, {{camera_azimut}}\n"),
            "line 1: {{camera_azimut}} is not a known slot; write {{camera_azimuth}} or remove it");
  EXPECT_EQ(refusal_of("user.md", "Name: {{name}}\n{{}}\n").substr(0, 72),
            "line 2: {{}} does not name a slot; remove it or write one of {{camera_az");
  EXPECT_EQ(refusal_of("user.md", "Name: {{name}} of {{size\n"),
            "line 1: {{size has no end; write it as {{slot}}, on one line");
  EXPECT_EQ(refusal_of("user.md", "Name: {{name}} of {{size} m\n"),
            "line 1: {{size has no end; write it as {{slot}}, on one line");
  EXPECT_EQ(refusal_of("user.md", "Name: {{ name }}{{name}}\n"),
            "line 1: {{ name }} is not a known slot; write {{name}} or remove it");
  EXPECT_EQ(refusal_of("user.md", ""),
            "has no {{name}}; write it where the text belongs, or delete the file to use the built-in one");
  EXPECT_EQ(refusal_of("repair.md", "{{problem}} {{name}}\n"),
            "line 1: {{name}} is not a known slot; remove it or write one of {{problem}}");
  EXPECT_EQ(refusal_of("answer_turn.md", "About {{name}}.\n"),
            "line 1: {{name}} is not a known slot; no slot of this text is filled; remove it");
  EXPECT_EQ(refusal_of("answer_turn.md", "Write {\"a\": {\"b\": 1}}, never {{...}}.\n"), "");
  EXPECT_EQ(refusal_of("search.md", "{{name}} {{size}} {{scale}}\n"),
            "");  // filled from the slots of the question
  EXPECT_EQ(refusal_of("search.md", "{{name}} {{others}}\n").substr(0, 41),
            "line 1: {{others}} is not a known slot; r");
  EXPECT_EQ(refusal_of("complaints.json", with_line("complaints.json", "too_deep", "no {{field}}")),
            "too_deep, line 1: {{field}} is not a known slot; no slot of this text is filled; remove it");
  EXPECT_EQ(refusal_of("complaints.json", with_line("complaints.json", "too_wide", "no {{feild}}")),
            "too_wide, line 1: {{feild}} is not a known slot; write {{field}} or remove it");
  EXPECT_EQ(refusal_of("facts.json", with_line("facts.json", "size", "{{long}} m\u2028{{hight}}\x1b")),
            "size, line 1: {{hight}} is not a known slot; write {{height}} or remove it");
}

// All built-in files, loaded from a folder.
TEST(PromptFolder, BuiltInFilesAreValid) {
  const auto built_in = PromptSet::load({}), folder = PromptSet::load(kRepository / "prompts");
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_EQ(folder->version(), built_in->version());
}

}  // namespace
}  // namespace livegs

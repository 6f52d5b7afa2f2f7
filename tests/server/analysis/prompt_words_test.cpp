// SPDX-License-Identifier: Apache-2.0
#include "analysis/prompt_words.h"

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "analysis/ask_model.h"
#include "analysis/fact_slots.h"
#include "analysis/gate.h"
#include "analysis/knowledge_search.h"
#include "analysis/model_endpoint.h"
#include "analysis/prompt_set.h"
#include "core/file.h"
#include "model_endpoint_cases.h"
#include "scratch_folder.h"
#include "server/analysis/answer_fixtures.h"

namespace livegs {
namespace {

namespace fs = std::filesystem;
const fs::path kRepository = fs::path(LIVEGS_TESTS_DIR) / "..";

// A line is said by its name, and a name that is in no file would be sent in its place.
TEST(PromptWords, EveryLineIsSaidAndEveryLineThatIsSaidIsThere) {
  std::string code;
  for (const auto& file : fs::directory_iterator(kRepository / "server/analysis")) {
    if (file.path().extension() == ".cpp") code += *read_text_file(file.path());
  }
  const auto& lines = PromptWords::built_in().lines();
  ASSERT_GT(lines.size(), 60u);
  const std::regex slot("\\{\\{([a-z_]+)\\}\\}");
  for (const auto& [name, text] : lines) {
    EXPECT_NE(code.find("\"" + name + "\""), std::string::npos) << name;
    for (std::sregex_iterator at(text.begin(), text.end(), slot), end; at != end; ++at)
      EXPECT_NE(code.find("{\"" + (*at)[1].str() + "\", "), std::string::npos) << name << " " << (*at)[1];
  }
  const std::regex said(R"re((?:\bsay|\bfail|\bwrong|\brequire)\(\s*(?:"[a-z_]+", (?="form_))?"([a-z_0-9]+)"|"(form_[a-z]+)")re");
  int count = 0;
  for (std::sregex_iterator at(code.begin(), code.end(), said), end; at != end; ++at) {
    const std::string name = (*at)[1].matched ? (*at)[1] : (*at)[2];
    EXPECT_TRUE(lines.contains(name)) << (*at)[0];
    ++count;
  }
  EXPECT_GT(count, 60);
}

// To the byte what was told before the words were in files (version 2).
TEST(PromptWords, FactsAreToldAsTheyWere) {
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
  const std::vector<SceneObjectFacts> neighbours = {{"cup", "", "", 0, {0.1, 0.2, 0.3}, 1.5, true},
                                                    {"a \"pot\"\n", "terracotta", "rigid", 0.7, {0.1, 0.1, 0.1}, 0.5, false}};
  const auto slots = fact_slots(facts, offline, neighbours);
  EXPECT_EQ(slots.at("size"), "0.08 x 0.095 x 0.08 m");
  EXPECT_EQ(slots.at("scale"), "metric");
  EXPECT_EQ(slots.at("mesh"),
            "smallest box 9.5 x 8 x 8 cm, encloses 120 cm3, surface 550 cm2, mean wall 2V/A 4.4 mm, 25 % of its convex hull, "
            "60 % open, rod, 2 pieces");
  EXPECT_EQ(slots.at("looks"),
            "mean colour #3380e6, saturation 0.30, spread of hue 0.70 rad, opacity 0.70, gloss 0.33");
  EXPECT_EQ(slots.at("neighbours"),
            "- \"a 'pot' \": 700 g, terracotta, rigid, 0.1 x 0.1 x 0.1 m, 0.5 m away (estimated offline)\n"
            "- \"cup\": 0.1 x 0.2 x 0.3 m, 1.5 m away");
  EXPECT_TRUE(slots.at("materials").starts_with("- stoneware (ceramic): 2000 to 2400 kg/m3, Young's modulus 4e+04 MPa (3e+04 to 6e+04), plasticity 0, fragile"))
      << slots.at("materials");
  EXPECT_EQ(slots.at("offline"), "mug of stoneware, mass 300 g (250 to 400), RIGID, confidence 0.50; as it says");
  EXPECT_EQ(slots.at("told"), "mass_kg 0.3, friction 0.4");
}

// Of a sponge, that is of one stuff whatever it is, as of a mug and of what has no name.
TEST(PromptWords, ThreeMaterialsAreToldWithTheirRanges) {
  for (ObjectFacts facts : {sponge_facts(), mug_facts(), tennis_ball_facts(), pillow_facts()}) {
    for (const char* name : {facts.name.c_str(), "brick", "steel ball", "hammer", ""}) {
      facts.name = name;
      const std::string told = fact_slots(facts, estimate_offline(facts), {}).at("materials");
      const std::regex line(R"(- ([^(]+) \([a-z]+\): [0-9.e+]+ to [0-9.e+]+ kg/m3, Young's modulus [^ ]+ MPa \([^ ]+ to [^ ]+\), .*)");
      std::istringstream lines(told);
      std::set<std::string> names;
      for (std::string one; std::getline(lines, one);) {
        std::smatch found;
        ASSERT_TRUE(std::regex_match(one, found, line)) << one;
        EXPECT_TRUE(names.insert(found[1]).second) << told;
      }
      EXPECT_EQ(names.size(), 3u) << name << "\n" << told;
    }
  }
}

TEST(KnowledgeSearch, WhatIsMostLikeAMaterialIsOfItsKind) {
  const auto first = [](const char* name) { return similar_materials(material_row(name), 3).front()->material_class; };
  for (const char* name : {"stoneware", "carbon steel", "soda-lime glass", "polyurethane foam", "softwood", "polypropylene"})
    EXPECT_EQ(first(name), material_row(name).material_class) << name;
  EXPECT_EQ(similar_materials(material_row("carbon steel"), 1).front()->name, "tinplate");  // tinned steel
  EXPECT_EQ(similar_materials(material_row("brass"), 1000).size(), material_table().size() - 1);
}

TEST(PromptWords, WhatFillsASlotIsNotLookedAtAgain) {
  const PromptWords& words = PromptWords::built_in();
  EXPECT_EQ(words.say("part_unknown", {{"field", "parts[0]"}, {"told", "{{field}}"}}),
            "parts[0].material_id: \"{{field}}\" is not in the table; give a name from it");
  EXPECT_EQ(words.say("part_unknown", {{"field", "parts[0]"}, {"told", ""}}),
            "parts[0].material_id: \"\" is not in the table; give a name from it");
}

// prompts/FILE with one line in other words.
std::string with_line(const char* file, const char* line, const char* text) {
  auto json = nlohmann::ordered_json::parse(*read_text_file(kRepository / "prompts" / file));
  json.at(line) = text;
  return json.dump(1);
}

TEST(PromptWords, AFoldersOwnWordsReachTheModelAndMakeAnotherVersion) {
  const ScratchFolder scratch;
  scratch.write("prompts/facts.json", with_line("facts.json", "size", "LONG {{length}}"));
  scratch.write("prompts/complaints.json", with_line("complaints.json", "out_of_order", "SORT {{field}}{{in_unit}}"));
  scratch.write("prompts/tool_words.json", with_line("tool_words.json", "no_row", "NO ROW"));
  nlohmann::json wrong = mug_answer();
  wrong["mass_g"]["low"] = 1000;
  TestModelServer server(in_turn({calls({{"kb_get", R"({"id":"unobtainium"})"}}), says(wrong.dump()), says(mug_answer().dump())}));
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
  ask_model(target, {}, **endpoint, (*endpoint)->state(), look, {}, [](AnalysisStage) {}, {}, update);
  ASSERT_EQ(update.judgement.verdict, Verdict::Accepted) << update.judgement.message;
  const auto posts = server.posts();
  ASSERT_EQ(posts.size(), 3u);
  EXPECT_NE(posts[0].body.find("LONG 0.08\\n"), std::string::npos) << posts[0].body;
  EXPECT_NE(posts[1].body.find("NO ROW"), std::string::npos);
  EXPECT_NE(posts[2].body.find("SORT mass_g, in grams"), std::string::npos);
  EXPECT_NE(PromptSet::load(scratch / "prompts")->version(), PromptSet::load({})->version());
}

TEST(PromptWords, AFileThatLacksALineOrHasOneMoreIsAnErrorThatNamesIt) {
  const ScratchFolder scratch;
  const auto refusal = [&](const std::string& text) {
    scratch.write("prompts/complaints.json", text);
    const auto loaded = PromptSet::load(scratch / "prompts");
    return loaded ? "" : loaded.error().message;
  };
  const std::string whole = *read_text_file(kRepository / "prompts/complaints.json");
  EXPECT_EQ(refusal(whole), "");
  nlohmann::json json = nlohmann::json::parse(whole);
  json.erase("too_wide");
  EXPECT_EQ(refusal(json.dump()), "prompts/complaints.json: has no line too_wide");
  json["too_wide"] = 3;
  EXPECT_EQ(refusal(json.dump()), "prompts/complaints.json: too_wide is no text");
  json["too_wide"] = json["to_wide"] = "x";
  EXPECT_EQ(refusal(json.dump()), "prompts/complaints.json: to_wide is no line that is ever said");
  EXPECT_EQ(refusal("["), "prompts/complaints.json: not a JSON object");
}

// Both ended the program.
TEST(PromptFolder, AFileOfAnotherFormIsAnErrorThatNamesIt) {
  const ScratchFolder scratch;
  const auto refusal = [&](const char* file, const std::string& text) {
    std::filesystem::remove_all(scratch / "prompts");
    scratch.write(std::string("prompts/") + file, text);
    const auto loaded = PromptSet::load(scratch / "prompts");
    return loaded ? "" : loaded.error().message;
  };
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_EQ(refusal("examples.json", R"({"a": {"facts": "x", "answer": {}}})"), "prompts/examples.json: must be a list of examples");
  EXPECT_EQ(refusal("examples.json", R"([{"facts": "x", "answer": )" + deep + "}]"), "prompts/examples.json: nested too deep");
  EXPECT_EQ(refusal("answer.schema.json", R"({"required": [], "enum": ["{{material_ids}}"], "a": )" + deep + "}"),
            "prompts/answer.schema.json: nested too deep");
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "json/json_message.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "livegs/v1/scene.pb.h"

namespace livegs {
namespace {

std::string refusal(const std::string& text) {
  v1::Scene scene;
  const auto parsed = parse_json_message(text, scene);
  return parsed ? "" : parsed.error().message;
}

TEST(JsonMessage, CommentsSpellingsAndNullAreAccepted) {
  v1::Scene scene;
  const auto parsed = parse_json_message(R"(// a scene
    { "rateHz": 60, "substeps": 4.0, /* "substeps": 5, */ "gravity_m_s2": [0, -1.5e0, "0"],
      "objects": [ { "name": "cup // \"of\" /* tea", "physics": { "behavior": 2 }, "scale": null },
                   { "physics": { "behavior": "ELASTIC" } } ] } // the end)",
                                         scene);
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(scene.rate_hz(), 60);
  EXPECT_EQ(scene.substeps(), 4);
  EXPECT_EQ(scene.gravity_m_s2(1), -1.5);
  EXPECT_EQ(scene.objects(0).name(), "cup // \"of\" /* tea");
  EXPECT_EQ(scene.objects(0).physics().behavior(), v1::Physics::RIGID);
  EXPECT_FALSE(scene.objects(0).has_scale());
  EXPECT_EQ(scene.objects(1).physics().behavior(), v1::Physics::ELASTIC);
  EXPECT_TRUE(parse_json_message("\xEF\xBB\xBF{}", scene));
  EXPECT_EQ(scene.objects_size(), 0);  // contents are replaced
}

// Each error has the position, the field and its object, the problem, and a remedy.
TEST(JsonMessage, RefusalsAreExact) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "line 1, column 1: is not JSON: the file is empty"},
      {"  // nothing\n", "line 2, column 1: is not JSON: the file is empty"},
      {"[]", "line 1, column 1: must be one JSON object, { … }"},
      {"{} {}", "line 1, column 4: is not JSON: more text after the end of the object"},
      {R"({ "objects": [ { "nme": "cup" } ] })",
       R"(line 1, column 18: objects[0]: unknown field "nme"; did you mean "name"?)"},
      {"{\n  \"objects\": [\n    { \"name\": \"cup\", \"physics\": { \"behavior\": \"SQUISHY\" } } ] }",
       "line 3, column 47: objects[0].physics.behavior of \"cup\": must be AUTO, STATIC, RIGID or ELASTIC, "
       "not "
       "\"SQUISHY\""},
      {R"({ "objects": [ { "physics": { "behavior": "elastic" } } ] })",
       "line 1, column 43: objects[0].physics.behavior: must be AUTO, STATIC, RIGID or ELASTIC, not "
       "\"elastic\"; "
       "did you mean \"ELASTIC\"?"},
      {R"({ "objects": [ { "physics": { "behavior": 9 } } ] })",
       "line 1, column 43: objects[0].physics.behavior: must be AUTO, STATIC, RIGID or ELASTIC, not 9"},
      {R"({ "rate_hz": "fast" })", "line 1, column 14: rate_hz: must be a number, not \"fast\""},
      {R"({ "rate_hz": .5 })", "line 1, column 14: rate_hz: must be a number, not .5"},
      {R"({ "rate_hz": NaN })", "line 1, column 14: rate_hz: must be a number, not NaN"},
      {R"({ "rate_hz": 090 })", "line 1, column 14: rate_hz: must be a number, not 090"},
      {R"({ "rate_hz": 1e999 })",
       "line 1, column 14: rate_hz: is out of range: must be from -1.8e+308 to "
       "1.8e+308, not 1e999"},
      {R"({ "rate_hz": [90] })", "line 1, column 14: rate_hz: must be a number, not a list"},
      {R"({ "substeps": 2.5 })", "line 1, column 15: substeps: must be a whole number, not 2.5"},
      {R"({ "substeps": 3000000000 })",
       "line 1, column 15: substeps: is out of range: must be from -2147483648 "
       "to 2147483647, not 3000000000"},
      {R"({ "substeps": true })", "line 1, column 15: substeps: must be a number, not true"},
      {R"({ "gravity_m_s2": -9.81 })", "line 1, column 19: gravity_m_s2: must be a list, [ … ], not -9.81"},
      {R"({ "gravity_m_s2": [0, "down", 0] })",
       "line 1, column 23: gravity_m_s2[1]: must be a number, not \"down\""},
      {R"({ "objects": { "name": "cup" } })",
       "line 1, column 14: objects: must be a list, [ … ], not an object"},
      {R"({ "objects": [ "cup" ] })", "line 1, column 16: objects[0]: must be an object, { … }, not \"cup\""},
      {R"({ "objects": [ { "name": 7 } ] })",
       "line 1, column 26: objects[0].name: must be a text in quotes, not 7"},
      {R"({ "environment": { "collide": "yes" } })",
       "line 1, column 31: environment.collide: must be true or false, not \"yes\""},
      {R"({ "objects": [ { "name": "a", "name": "b" } ] })",
       R"(line 1, column 31: objects[0] of "a": "name" is given twice; remove one)"},
      {R"({ "rate_hz": 90, "rateHz": 60 })", R"(line 1, column 18: "rateHz" is given twice; remove one)"},
      {R"({ "objects": [ { "shape": { "box": {}, "sphere": {} } } ] })",
       R"(line 1, column 40: objects[0].shape: "box" and "sphere" exclude each other; remove one)"},
      {R"({ "objects": [ { "shape": { "cube": {} } } ] })",
       R"(line 1, column 29: objects[0].shape: unknown field "cube"; the fields here are )"},
      {"{ \"objects\": [\n  { \"name\": \"cup\"",
       "line 2, column 18: objects[0] of \"cup\": is not JSON: the text ends within what begins at line 2, "
       "column 3"},
      {"{ \"objects\": [",
       "line 1, column 15: objects: is not JSON: the text ends within what begins at line 1, "
       "column 14"},
      {"{ \"objects\": [ { \"name\": \"cu",
       "line 1, column 26: objects[0].name: is not JSON: a text in quotes "
       "does not end"},
      {"{ \"name", "line 1, column 3: is not JSON: a text in quotes does not end"},
      {"{ \"rate_hz\" 90 }", "line 1, column 13: is not JSON: a colon after \"rate_hz\" is missing"},
      {"{ \"rate_hz\": 90 \"substeps\": 4 }", "line 1, column 17: is not JSON: a comma or } is missing"},
      {"{ \"gravity_m_s2\": [0 1] }",
       "line 1, column 22: gravity_m_s2: is not JSON: a comma or ] is missing"},
      {"{ \"rate_hz\": 90, }", "line 1, column 16: is not JSON: a comma before }; remove it"},
      {"{ rate_hz: 90 }", "line 1, column 3: is not JSON: a field begins with its name in quotes"},
      {"{ /* rate_hz", "line 1, column 3: is not JSON: a comment does not end; add */"},
      {"{ \"rate_hz\": }", "line 1, column 14: rate_hz: must be a number, not }"},
      {R"({ "objects": [ { "asset": "C:\cup.ply" } ] })",
       R"(line 1, column 30: objects[0].asset: is not JSON: a backslash in a text; write \\ or /)"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string message = refusal(text);
    EXPECT_EQ(message.find(expected), 0u) << text << "\n  is:     " << message << "\n  not as: " << expected;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(message.find("livegs.v1"), std::string::npos) << message;
  }
}

TEST(JsonMessage, EveryTruncationOfASceneIsRefusedWithItsPosition) {
  const std::string text = R"({ "rate_hz": 90, // Hz
    "objects": [ { "name": "cup", "pose": { "position_m": [0, 0.5, 0] }, "physics": { "behavior": "RIGID" } } ] })";
  EXPECT_EQ(refusal(text), "");
  for (size_t length = 0; length < text.size(); ++length) {
    const std::string message = refusal(text.substr(0, length));
    EXPECT_EQ(message.find("line "), 0u) << length << ": " << message;
  }
}

TEST(JsonMessage, AnyBytesGiveAnAnswer) {
  EXPECT_NE(refusal(std::string("{ \"objects\": ") + std::string(400'000, '[')), "");
  EXPECT_NE(refusal("{ \"objects\": [ { \"name\": \"\xFF\xFE\" } ] }"), "");
  EXPECT_NE(refusal(std::string("{\0}", 3)), "");
  EXPECT_NE(refusal("{ \"" + std::string(100'000, 'x') + "\": 1 }"), "");
}

}  // namespace
}  // namespace livegs

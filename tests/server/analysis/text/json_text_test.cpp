// SPDX-License-Identifier: Apache-2.0
#include "analysis/text/json_text.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "analysis/gate/answer.h"
#include "analysis/gate/answer_object.h"

namespace livegs {
namespace {

constexpr std::size_t kNowhere = std::string_view::npos;

TEST(JsonExtent, FindsEndAndDepth) {
  const auto check = [](std::string_view text, std::size_t begin, std::size_t end, int depth) {
    const JsonExtent extent = json_extent(text, begin, 4);
    EXPECT_EQ(extent.end, end) << text;
    EXPECT_EQ(extent.depth, depth) << text;
  };
  check("{}", 0, 2, 1);
  check(R"({"a":[1,{}]} {)", 0, 12, 3);
  check(R"({"a":[1,{}]} {)", 5, 11, 2);
  check(R"({"}":"]{[","\"}":1}x)", 0, 19, 1);  // brackets and quotes in strings
  check(R"({"a":"never closed})", 0, kNowhere, 1);
  check(R"({"a":1)", 0, kNowhere, 1);
  check("{]", 0, 2, 1);  // refused later by the parser
  check("[[[[]]]]", 0, 8, 4);
  check("[[[[[]]]]]", 0, kNowhere, 5);  // deeper than 4
  check("none", 0, kNowhere, 0);
  check("] [", 0, 1, 0);
  check("", 0, kNowhere, 0);
  check("{}", 7, kNowhere, 0);
  check("{\"\\", 0, kNowhere, 1);  // ends within an escape
}

// A closed extent of valid JSON is the value itself, in any surroundings.
TEST(JsonExtent, ExtractsValuesFromAnySurroundings) {
  std::mt19937_64 random(5);
  const auto below = [&](std::size_t count) { return static_cast<std::size_t>(random() % count); };
  const std::function<Json(int)> value = [&](int depth) -> Json {
    switch (depth > 0 ? below(5) : 2 + below(3)) {
      case 0: {
        Json object = Json::object();
        for (std::size_t i = below(4); i > 0; --i) object["k}" + std::to_string(i)] = value(depth - 1);
        return object;
      }
      case 1: {
        Json array = Json::array();
        for (std::size_t i = below(4); i > 0; --i) array.push_back(value(depth - 1));
        return array;
      }
      case 2:
        return "\\\"{[" + std::string(below(3), '}');
      case 3:
        return static_cast<int>(below(1000));
      default:
        return nullptr;
    }
  };
  for (int i = 0; i < 500; ++i) {
    const std::string text = dump_json(Json{{"v", value(6)}});
    const JsonExtent extent = json_extent("prose " + text + " }]", 6, kMaxJsonDepth);
    ASSERT_EQ(extent.end, 6 + text.size()) << text;
    ASSERT_TRUE(parse_json(text)) << text;
  }
}

TEST(ParseJson, RefusesDeepNestingBeforeParsing) {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_TRUE(parse_json(nested(64)));
  EXPECT_EQ(parse_json(nested(65)).error().message, "JSON nested deeper than 64 levels");
  EXPECT_EQ(parse_json("[] " + nested(65)).error().message, "JSON nested deeper than 64 levels");
  EXPECT_EQ(parse_json(std::string(1000000, '[')).error().message, "JSON nested deeper than 64 levels");
  EXPECT_EQ(parse_json(std::string(1000000, ']')).error().message, "not JSON");
  EXPECT_TRUE(parse_json("\"" + std::string(100, '[') + "\""));
  EXPECT_EQ(parse_json("").error().message, "not JSON");
  EXPECT_EQ(parse_json("{} {}").error().message, "not JSON");
}

TEST(FindJsonObject, SelectsTheObjectWithMostWantedKeys) {
  const std::vector<std::string> wanted = {"mass_g", "fill"};
  const auto found = [&](std::string_view text) {
    const auto object = find_json_object(text, wanted);
    return object ? dump_json(*object) : "";
  };
  EXPECT_EQ(found(R"(a {"mass_g":1,"fill":"s"} b {"x":1})"), R"({"fill":"s","mass_g":1})");
  EXPECT_EQ(found(R"({"mass_g":1} then {"mass_g":2})"), R"({"mass_g":2})");  // the last of equal ones
  EXPECT_EQ(found(R"({"a":"}{","mass_g":3})"), R"({"a":"}{","mass_g":3})");
  EXPECT_EQ(found("none { here"), "");
  EXPECT_EQ(found(std::string(100000, '{')), "");
}

TEST(AnswerObject, ExtractsTheObjectWithAMassFromProse) {
  const auto found = [](const std::string& text) {
    const auto object = answer_object(text);
    return object ? dump_json(*object) : object.error().message;
  };
  EXPECT_EQ(found(R"(so: ```{"mass_g":{"best":1}}``` done {"x":1} {)"), R"({"mass_g":{"best":1}})");
  EXPECT_EQ(found(R"({"mass_g":1} or again {"mass_g":1})"), R"({"mass_g":1})");
  EXPECT_NE(found(R"({"mass_g":1} or {"mass_g":2})").find("more than one object"), std::string::npos);
  EXPECT_NE(found(R"({"mass_g":1)").find("no complete JSON object"), std::string::npos);
  EXPECT_NE(found(R"({"mass_g":1])").find("no complete JSON object"), std::string::npos);
  EXPECT_EQ(found(R"({"a" {"mass_g":1})"), R"({"mass_g":1})");  // the first never closes
  const auto deep = [](std::size_t depth) {
    return "{\"mass_g\":" + std::string(depth - 1, '[') + std::string(depth - 1, ']') + "}";
  };
  EXPECT_TRUE(answer_object(deep(kMaxAnswerDepth)));
  EXPECT_NE(found(deep(kMaxAnswerDepth + 1)).find("nested too deep"), std::string::npos);
  EXPECT_NE(found("{\"mass_g\":" + std::string(50, '[')).find("nested too deep"), std::string::npos);
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
// Answers with more parts than a user can edit, and with parts of equal names.
#include <gtest/gtest.h>

#include <numeric>

#include "analysis/division/part_places.h"
#include "analysis/gate/answer_parts.h"
#include "server/analysis/gate/judge_answer.h"

namespace livegs {
namespace {

using nlohmann::json;

json listed_part(const std::string& name, const char* material, double share, const json& boxes = nullptr) {
  return {{"name", name},
          {"material_id", material},
          {"share", share},
          {"thickness_mm", nullptr},
          {"boxes", boxes}};
}
Answer answer_of(const json& parts) {
  json answer = mug_answer();
  answer["parts"] = parts;
  const auto read = read_answer(answer.dump());
  EXPECT_TRUE(read) << read.error().message;
  return read ? *read : Answer();
}
// The lines of changes about the list of parts.
std::vector<std::string> notes(const std::vector<std::string>& changes) {
  std::vector<std::string> found;
  for (const std::string& line : changes) {
    if (line.starts_with("parts: ")) found.push_back(line);
  }
  return found;
}
double sum_of_shares(const std::vector<AnswerPart>& parts) {
  return std::accumulate(parts.begin(), parts.end(), 0.0,
                         [](double sum, const AnswerPart& part) { return sum + part.share; });
}

// Four legs outweigh the seat, so the chair is of their material.
TEST(AnswerParts, EqualPartsAreJoined) {
  const Answer answer = answer_of({listed_part("seat", "ABS", 0.4, {{1, 0, 0, 1000, 400}}),
                                   listed_part("leg", "hardwood", 0.15, {{1, 0, 400, 100, 1000}}),
                                   listed_part("Leg", "hardwood", 0.15, {{1, 300, 400, 400, 1000}}),
                                   listed_part("leg", "hardwood", 0.15),
                                   listed_part("leg", "hardwood", 0.15, {{2, 900, 400, 1000, 1000}})});
  ASSERT_EQ(answer.parts.size(), 2u);
  EXPECT_EQ(answer.parts[0].name, "leg");
  EXPECT_NEAR(answer.parts[0].share, 0.6, 1e-12);
  EXPECT_EQ(answer.parts[0].boxes.size(), 3u);
  EXPECT_EQ(answer.parts[1].boxes.size(), 1u);
  EXPECT_EQ(notes(answer.changes),
            std::vector<std::string>{"parts: those of one name and material were joined: leg"});
}

TEST(AnswerParts, OtherEqualNamesGetNumbers) {
  const Answer answer =
      answer_of({listed_part("grip", "hardwood", 0.4), listed_part("grip", "ABS", 0.3),
                 listed_part("grip 2", "ABS", 0.2), listed_part("", "natural rubber", 0.1)});
  ASSERT_EQ(answer.parts.size(), 4u);
  EXPECT_EQ(answer.parts[0].name, "grip");
  EXPECT_EQ(answer.parts[1].name, "grip 3") << "the second one has the name of another";
  EXPECT_EQ(answer.parts[2].name, "grip 2");
  EXPECT_EQ(answer.parts[3].name, "natural rubber");
  EXPECT_EQ(notes(answer.changes), std::vector<std::string>{"parts: equal names got numbers: grip"});
}

// Whatever a model lists, its values count, and the parts can be edited.
TEST(AnswerParts, ManyPartsAreLimited) {
  for (const int count : {2, 8, 9, 20, 32, 33, 200}) {
    json answer = mug_answer();
    answer["parts"] = json::array();
    for (int i = 0; i < count; ++i)
      answer["parts"].push_back(listed_part("piece " + std::to_string(i), "stoneware", 1.0 / count));
    const Judgement judgement = judge(answer);
    ASSERT_EQ(judgement.verdict, Verdict::Accepted) << count << ": " << judgement.message;
    const MaterialParts& parts = judgement.parameters.parts();
    EXPECT_EQ(parts.size(), std::min(count, kMaxMaterialParts));
    const auto checked = check_parts(parts);
    EXPECT_TRUE(checked) << count << ": " << checked.error().message;
    EXPECT_EQ(notes(judgement.changes).empty(), count <= 8) << count;
    EXPECT_EQ(judgement.parameters.mass_kg().best(), judge(mug_answer()).parameters.mass_kg().best());
  }
}

TEST(AnswerParts, SurplusGoesToTheSameMaterial) {
  const MaterialRow* wood = find_material_row("hardwood");
  const MaterialRow* steel = find_material_row("carbon steel");
  const MaterialRow* foam = find_material_row("polyurethane foam");
  ASSERT_TRUE(wood && steel && foam);
  const auto part = [](const char* name, const MaterialRow* material, double share, std::vector<float> votes,
                       const char* inside = "") {
    AnswerPart one;
    one.name = name;
    one.material = material;
    one.share = share;
    one.votes = std::move(votes);
    one.inside = inside;
    return one;
  };
  std::vector<AnswerPart> parts = {
      part("frame", wood, 0.4, {1, 0, 0}), part("filling", foam, 0.3, {0, 1, 0}, "Cover"),
      part("blade", steel, 0.15, {0, 0, 1}), part("cover", steel, 0.1, {0, 2, 3}),
      part("label", foam, 0.05, {4, 0, 0}, "frame")};
  std::vector<std::string> changes;
  limit_parts(parts, 3, changes);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_NEAR(sum_of_shares(parts), 1, 1e-12);
  EXPECT_EQ(parts[0].name, "frame");
  EXPECT_EQ(parts[1].name, "filling");
  EXPECT_EQ(parts[2].name, "blade");
  EXPECT_NEAR(parts[1].share, 0.35, 1e-12);
  EXPECT_NEAR(parts[2].share, 0.25, 1e-12);
  EXPECT_EQ(parts[2].votes, (std::vector<float>{0, 2, 4}));
  EXPECT_EQ(parts[1].votes, (std::vector<float>{4, 1, 0}));
  EXPECT_EQ(parts[1].inside, "blade") << "the part that the cover was added to";
  EXPECT_EQ(changes,
            std::vector<std::string>{"parts: 5 are given; the 2 smallest were added to the larger ones"});
  // Without a part of the same material, the largest takes it, and encloses nothing of its own.
  limit_parts(parts, 2, changes);
  EXPECT_EQ(parts[0].name, "frame");
  EXPECT_NEAR(parts[0].share, 0.65, 1e-12);
  EXPECT_EQ(parts[1].inside, "frame");
  limit_parts(parts, 1, changes);
  EXPECT_EQ(parts[0].inside, "");
  EXPECT_NEAR(parts[0].share, 1, 1e-12);
}

}  // namespace
}  // namespace livegs

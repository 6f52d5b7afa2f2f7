// SPDX-License-Identifier: Apache-2.0
// Answers of a vision-language model about scanned objects without names, through the gate. The facts (names,
// masses, materials, measured surfaces) are from a trial of November 2026 with six objects of the YCB set;
// the true masses are those of its table.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "analysis/estimate/class_mass.h"
#include "server/analysis/estimate/known_objects.h"
#include "server/analysis/gate/judge_answer.h"
#include "server/analysis/gate/replayed_answers.h"
#include "server/analysis/gate/trial_objects.h"

namespace livegs {
namespace {

using nlohmann::json;

json mass_json(const Span3& mass_g) {
  return {{"low", mass_g.low}, {"high", mass_g.high}, {"best", mass_g.best}};
}

json json_of(const TrialAnswer& one) {
  json parts = json::array();
  for (const auto& [material, share] : one.parts) {
    parts.push_back(
        {{"name", "part"}, {"material_id", material}, {"share", share}, {"thickness_mm", nullptr}});
  }
  return {{"description", "seen"},  {"evidence", "seen"},         {"name", one.name},
          {"name_confidence", 0.8}, {"is_replica", one.replica},  {"fill", one.fill},
          {"parts", parts},         {"behaviour", one.behaviour}, {"mass_g", mass_json(one.mass_g)},
          {"young_mpa", nullptr},   {"structure_s", nullptr},     {"plasticity", nullptr},
          {"fragile", false},       {"friction", 0.45},           {"restitution", 0.4},
          {"confidence", 0.6},      {"kb_ids", json::array()}};
}

double error_of(double mass_kg, double truth_kg) { return std::abs(mass_kg - truth_kg) / truth_kg; }

// The paper reports 15 % for objects that its authors chose; the trial 12 % for sixteen of which these are
// six.
TEST(TrialAnswers, MassesStayNearTheAnswers) {
  double installed = 0, answered = 0;
  for (const TrialAnswer& one : trial_answers()) {
    const Judgement judgement = judge(json_of(one), trial_facts(one));
    ASSERT_EQ(judgement.verdict, Verdict::Accepted) << one.name << ": " << judgement.message;
    const auto& mass = judgement.parameters.mass_kg();
    std::printf("%-18s answered %6.1f g, installed %6.1f g (%.1f to %.1f), true %5.0f g\n", one.name,
                one.mass_g.best, 1e3 * mass.best(), 1e3 * mass.low(), 1e3 * mass.high(), one.truth_g);
    EXPECT_LE(mass.low(), 1e-3 * one.truth_g) << one.name;
    EXPECT_GE(mass.high(), 1e-3 * one.truth_g) << one.name;
    installed += error_of(mass.best(), 1e-3 * one.truth_g) / trial_answers().size();
    answered += error_of(one.mass_g.best, one.truth_g) / trial_answers().size();
  }
  std::printf("mean error: answered %.1f %%, installed %.1f %%\n", 100 * answered, 100 * installed);
  EXPECT_LE(installed, 0.12);
}

// An imitation keeps its mass under the name of its original, whose usual mass is not its own.
TEST(TrialAnswers, ReplicaAnsweredAsOneStaysOne) {
  const TrialAnswer& lemon = trial_answers().front();
  const double named_kg = judge(json_of(lemon), trial_facts(lemon)).parameters.mass_kg().best();
  json answer = json_of(lemon);
  answer["name"] = "lemon";
  const Judgement judgement = judge(answer, trial_facts(lemon));
  ASSERT_EQ(judgement.verdict, Verdict::Accepted) << judgement.message;
  EXPECT_NEAR(judgement.parameters.mass_kg().best(), named_kg, 1e-9);
  answer["is_replica"] = false;
  EXPECT_GT(judge(answer, trial_facts(lemon)).proposal.mass_kg().best(), 1.1 * named_kg);
}

// Two alternatives are one mixture: the mass is that of the likelier, and the range holds both.
TEST(TrialAnswers, AlternativesAreFusedAsOne) {
  const TrialAnswer& lemon = trial_answers().front();
  json answer = json_of(lemon);
  const json toy = {{"name", "artificial lemon"}, {"mass_g", mass_json({18, 30, 45})}},
             real = {{"name", "lemon"}, {"mass_g", mass_json({80, 95, 120})}};
  for (const double toy_share : {0.2, 0.7, 1.0}) {
    json first = toy, second = real;
    first["probability"] = toy_share;
    second["probability"] = 1 - toy_share;
    answer["alternatives"] = {second, first};
    const Judgement judgement = judge(answer, trial_facts(lemon));
    ASSERT_NE(judgement.verdict, Verdict::Refused) << judgement.message;
    const auto& mass = judgement.proposal.mass_kg();
    if (toy_share > 0.5) {
      EXPECT_LT(mass.best(), 0.05) << toy_share;
    } else {
      EXPECT_GT(mass.best(), 0.07) << toy_share;
    }
    if (toy_share < 1) {
      EXPECT_LT(mass.low(), 0.04) << toy_share;
      EXPECT_GT(mass.high(), 0.08) << toy_share;
    } else {
      EXPECT_LT(mass.high(), 0.07);
    }
  }
  // One alternative is the answer itself, in any order of the list.
  json sure = toy;
  sure["probability"] = 0.9;
  answer["alternatives"] = json::array({sure});
  json plain = answer;
  plain["alternatives"] = nullptr;
  plain["mass_g"] = toy["mass_g"];
  EXPECT_EQ(judge(answer, trial_facts(lemon)).proposal.mass_kg().best(),
            judge(plain, trial_facts(lemon)).proposal.mass_kg().best());
}

TEST(TrialAnswers, BadAlternativesAreRefusedInOneLine) {
  const TrialAnswer& lemon = trial_answers().front();
  const json sound = {{"name", "a"}, {"probability", 0.5}, {"mass_g", mass_json({10, 20, 30})}};
  const auto with = [&](const char* field, const json& value) {
    json one = sound;
    one[field] = value;
    return json::array({one, sound});
  };
  std::vector<json> bad = {"toy",
                           json{{"name", "a"}},
                           json::array({1, 2}),
                           with("probability", 1.5),
                           with("probability", "often"),
                           with("mass_g", mass_json({30, 20, 10})),
                           with("mass_g", nullptr),
                           with("mass_g", mass_json({-1, 2, 3}))};
  bad.push_back(json::array());
  for (int i = 0; i < 7; ++i) bad.back().push_back(sound);
  for (const json& one : bad) {
    json answer = json_of(lemon);
    answer["alternatives"] = one;
    const Judgement judgement = judge(answer, trial_facts(lemon));
    EXPECT_EQ(judgement.verdict, Verdict::Refused) << one.dump();
    EXPECT_NE(judgement.message.find("alternatives"), std::string::npos) << judgement.message;
    EXPECT_EQ(judgement.message.find('\n'), std::string::npos);
  }
  // An empty list and probabilities of zero say nothing.
  json none = json_of(lemon);
  none["alternatives"] = json::array();
  EXPECT_NE(judge(none, trial_facts(lemon)).verdict, Verdict::Refused);
}

// Answers in the style of the trial about all 26 objects. The goals are those of a mean error; ranges of 90 %
// hold 85 to 95 % of the true masses.
TEST(TrialAnswers, TablesDoNotWorsenGoodAnswers) {
  const std::vector<KnownObject>& objects = known_objects(KnownForm::Mesh);
  if (objects.empty()) GTEST_SKIP() << "no shared data";
  constexpr int kRepeats = 32;
  for (const auto& [name, max_error] :
       {std::pair(NameGiven::None, 0.12), std::pair(NameGiven::Label, 0.10)}) {
    const std::vector<MassAnswer> answers = replay_answers(objects, name, kRepeats);
    const MassScores scores = mass_scores(answers);
    std::printf("name %s: %zu answers, mean error %.1f %%, truth in the range %.1f %%\n",
                kNameGiven[static_cast<int>(name)], answers.size(), 100 * scores.mape.value,
                100 * scores.coverage.value);
    EXPECT_LE(scores.mape.value, max_error);
    EXPECT_GE(scores.coverage.value, 0.85);
    EXPECT_LE(scores.coverage.value, 0.95);
  }
}

// The same for generated objects, four of each class of the tables whose name has one meaning. The mass, and
// the volume or area for this mass, differ from those of the class as its row and its material say, with
// correlated errors. Neither the masses nor the classes are those of the 26 objects.
TEST(TrialAnswers, RangesAboutGeneratedObjectsAreOf90Percent) {
  std::mt19937_64 random(90);
  std::normal_distribution<double> normal;
  size_t held = 0, held_offline = 0, count = 0, refused = 0;
  double answered = 0, installed = 0, worst = 0;  // errors of ln(mass)
  std::string worst_label;
  for (int repeat = 0; repeat < 4; ++repeat) {
    for (const ObjectRow& row : object_table()) {
      if (!row.alternatives.empty()) continue;
      ObjectFacts facts = facts_of_row(row, row.label);
      const ClassMass usual = kind_mass({&row, 1, nullptr}, facts);
      const double first = normal(random), rho = kErrorCorrelation,
                   second = rho * first + std::sqrt(1 - rho * rho) * normal(random);
      const double truth_kg = usual.usual_kg * std::exp(row.mass_log_sd * first),
                   measured = truth_kg * std::exp(-usual.physics_sd * second) / usual.physics_kg;
      (usual.wall_m > 0 ? facts.mesh.area_m2 : facts.mesh.volume_m3) *= measured;
      const v1::EstimatedValue offline = estimate_offline(facts).mass_kg();
      facts.name.clear();
      const json answer = replayed_answer(row.label, truth_kg, facts, random);
      const Judgement judgement = judge(answer, facts);
      if (judgement.verdict == Verdict::Refused) {
        ++refused;
        continue;
      }
      ++count;
      const auto& mass = judgement.proposal.mass_kg();
      held += truth_kg >= mass.low() && truth_kg <= mass.high();
      held_offline += truth_kg >= offline.low() && truth_kg <= offline.high();
      answered += std::abs(std::log(1e-3 * answer["mass_g"]["best"].get<double>() / truth_kg));
      const double error = std::abs(std::log(mass.best() / truth_kg));
      installed += error;
      if (error > worst) worst = error, worst_label = row.label;
    }
  }
  answered /= count, installed /= count;
  std::printf(
      "%zu objects, %zu refused: answered %.3f, installed %.3f (at worst %.2f, %s), truth in the range "
      "%.1f %%; offline %.1f %%\n",
      count, refused, answered, installed, worst, worst_label.c_str(), 100.0 * held / count,
      100.0 * held_offline / count);
  EXPECT_LT(refused, count / 10);
  EXPECT_GE(1.0 * held / count, 0.85);
  EXPECT_LE(1.0 * held / count, 0.95);
  EXPECT_GE(1.0 * held_offline / count, 0.85);
  EXPECT_LE(1.0 * held_offline / count, 0.95);
  // The tables cost nothing. One light balloon is read in another unit, because rubber of its volume weighs
  // more.
  EXPECT_LE(installed, 1.01 * answered);
}

}  // namespace
}  // namespace livegs

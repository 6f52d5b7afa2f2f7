// SPDX-License-Identifier: Apache-2.0
// Step 8 of the gate (gate.h): an answer far from the prior, or inconsistent, becomes a proposal.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "analysis/estimate/class_mass.h"
#include "analysis/knowledge/tables.h"
#include "server/analysis/gate/answer_fixtures.h"
#include "server/analysis/gate/judge_answer.h"
#include "server/analysis/knowledge/table_things.h"

namespace livegs {
namespace {

using nlohmann::json;

TEST(GatePrior, AnswerFarFromThePriorIsAProposal) {
  const Judgement judgement =
      judge(with_fields(mug_answer(), {{"mass_g", {{"low", 2500}, {"best", 3500}, {"high", 5000}}}}));
  EXPECT_EQ(judgement.verdict, Verdict::NeedsReview);
  EXPECT_NE(judgement.message.find("mass_g"), std::string::npos);
  EXPECT_TRUE(same(judgement.parameters, estimate_offline(mug_facts())));
  EXPECT_GT(judgement.proposal.mass_kg().best(), 0.5);
}

// The threshold: an answer about an object of one class is held if its mass is 2.8 standard deviations away,
// those of the tables and of the answer together: exp(-2.8^2 / 2) = 0.02.
TEST(GatePrior, MassIsHeldByItsLikelihood) {
  ObjectFacts facts = sponge_facts();
  const ObjectClasses classes = object_classes(facts);
  ASSERT_EQ(classes.kinds.size(), 1u);
  const LogNormal usual = kind_mass(classes.kinds[0], facts).mass;
  const double limit = std::sqrt(2 * std::log(50));
  for (const double spread : {1.2, 2.0, 4.0}) {
    const double own_sd = std::max(0.1, std::log(spread) / 1.645), sd = std::hypot(usual.sd, own_sd);
    for (const double deviations : {-1.02, -0.98, 0.98, 1.02}) {
      const double best_g = 1e3 * std::exp(usual.mean_ln + deviations * limit * sd);
      const json answer =
          with_fields(sponge_answer(),
                      {{"mass_g", {{"low", best_g / spread}, {"best", best_g}, {"high", best_g * spread}}}});
      // Weighed without validation: the lightest of these sponges are lighter than their material.
      const auto read = read_answer(answer.dump());
      ASSERT_TRUE(read) << read.error().message;
      const Judgement judgement = weigh_answer(*read, facts, estimate_offline(facts));
      const bool held = judgement.message.find("is unlikely") != std::string::npos;
      EXPECT_EQ(held, std::abs(deviations) > 1) << spread << " " << deviations << ": " << judgement.message;
    }
  }
}

// The name of an object without a name comes from the answer, and its mass with it.
TEST(GatePrior, MassIsComparedWithWhatTheAnswerNames) {
  ObjectFacts unnamed = pillow_facts();
  unnamed.name = "";
  unnamed.scale_known = false;
  const auto with_mass = [](double best_g) {
    return with_fields(pillow_answer(),
                       {{"mass_g", {{"low", best_g / 1.5}, {"best", best_g}, {"high", best_g * 1.5}}}});
  };
  EXPECT_EQ(judge(with_mass(450), unnamed).verdict, Verdict::Accepted);
  const Judgement heavy = judge(with_mass(9000), unnamed);
  EXPECT_EQ(heavy.verdict, Verdict::NeedsReview);
  EXPECT_NE(heavy.message.find("\"throw pillow\" of this size"), std::string::npos) << heavy.message;
}

// A null in the answer is checked as well, by the value that would be installed.
TEST(GatePrior, ContradictionOfTheNameIsAProposal) {
  const json no_e = {{"young_mpa", nullptr}, {"structure_s", nullptr}, {"plasticity", nullptr}};
  const json soft_mug =
      with_fields(mug_answer(), {{"young_mpa", nullptr}, {"behaviour", "elastic"}, {"fragile", false}});
  const json foam_e = {{"low", 0.02}, {"best", 0.05}, {"high", 0.1}};
  ObjectFacts guessed_mug = mug_facts();
  guessed_mug.name = "025_mug";
  guessed_mug.scale_known = false;
  ASSERT_LT(estimate_offline(guessed_mug).confidence(), 0.4);
  json mixed = with_fields(mug_answer(), no_e);
  mixed["parts"] = {
      {{"name", "glaze"}, {"material_id", "stoneware"}, {"share", 0.01}, {"thickness_mm", 4}},
      {{"name", "body"}, {"material_id", "PU cushion foam"}, {"share", 0.99}, {"thickness_mm", nullptr}}};
  ObjectFacts unnamed = mug_facts();
  unnamed.name = "";
  json light = mixed;
  light["mass_g"] = {{"low", 8}, {"best", 10}, {"high", 14}};
  const std::tuple<const char*, ObjectFacts, json, const char*> cases[] = {
      {"mug of foam", mug_facts(),
       with_fields(soft_mug, {{"parts", all_of("polyurethane foam")}, {"structure_s", nullptr}}), "mass_g"},
      {"mug of foam, heavy, E given", mug_facts(),
       with_fields(soft_mug, {{"parts", all_of("polyurethane foam")}, {"young_mpa", foam_e}}), "mass_g"},
      {"soft stoneware", mug_facts(), with_fields(soft_mug, {{"structure_s", 0.001}}), "behaviour"},
      {"a crumb of stoneware", mug_facts(), mixed, "mass_g"},
      {"a crumb of stoneware, unnamed and light", unnamed, light, ""},
      {"steel sponge", sponge_facts(),
       with_fields(with_fields(sponge_answer(), no_e),
                   {{"parts", all_of("carbon steel")}, {"behaviour", "rigid"}}),
       ""},
      {"sponge of 50 Pa", sponge_facts(),
       with_fields(sponge_answer(), {{"young_mpa", nullptr}, {"structure_s", 0.001}}), "structure_s"},
      {"tennis ball as a mug", tennis_ball_facts(), with_fields(mug_answer(), no_e), "mass_g"},
      {"tennis ball as a light mug", tennis_ball_facts(),
       with_fields(with_fields(mug_answer(), no_e), {{"name", "thing"}, {"mass_g", 60}}), "behaviour"},
      {"mug of foam, scale guessed", guessed_mug,
       with_fields(soft_mug, {{"parts", all_of("polyurethane foam")}, {"young_mpa", foam_e}, {"mass_g", 30}}),
       "behaviour"},
      {"elastic of stoneware's name", guessed_mug,
       with_fields(soft_mug, {{"parts", all_of("EVA foam")}, {"structure_s", nullptr}, {"mass_g", 60}}),
       "behaviour"},
  };
  for (const auto& [name, facts, answer, word] : cases) {
    const auto offline = estimate_offline(facts);
    const Judgement judgement = judge_answer(answer.dump(), facts, offline);
    EXPECT_EQ(judgement.verdict, Verdict::NeedsReview) << name << ": " << judgement.message;
    EXPECT_TRUE(judgement.message.starts_with(word)) << name << ": " << judgement.message;
    EXPECT_TRUE(same(judgement.parameters, offline)) << name;
  }
}

// Minimum material: 1/64 of a lump of 1000 cm3; for a wall, 1/12 of thickness times area.
TEST(GatePrior, TooLittleMaterialIsAProposal) {
  ObjectFacts lump;
  lump.scale_known = true;
  lump.mesh.size_m = lump.mesh.principal_size_m = lump.mesh.box_m = {0.1, 0.1, 0.1};
  lump.mesh.volume_m3 = lump.mesh.hull_volume_m3 = 1e-3;
  lump.mesh.area_m2 = 0.06;
  lump.mesh.mean_wall_m = 2e-3 / 0.06;
  lump.mesh.solidity = 1;
  lump.mesh.piece_count = 1;
  const auto verdict = [&](const ObjectFacts& facts, const char* fill, const char* material,
                           const json& wall_mm, double mass_g) {
    json answer = with_fields(mug_answer(), {{"name", "thing"},
                                             {"fill", fill},
                                             {"parts", all_of(material)},
                                             {"mass_g", mass_g},
                                             {"young_mpa", nullptr},
                                             {"structure_s", nullptr},
                                             {"fragile", false}});
    answer["parts"][0]["thickness_mm"] = wall_mm;
    const Judgement judgement = judge_answer(answer.dump(), facts, v1::PhysicalParameters());
    EXPECT_NE(judgement.verdict, Verdict::Refused) << judgement.message;
    if (judgement.verdict == Verdict::NeedsReview) {
      EXPECT_TRUE(judgement.message.starts_with("mass_g.best")) << judgement.message;
    }
    return judgement.verdict;
  };
  const double steel = 1e-3 * material_row("carbon steel").density_kg_m3.low;  // g/cm3
  EXPECT_EQ(verdict(lump, "solid", "carbon steel", nullptr, 16 * steel), Verdict::Accepted);
  EXPECT_EQ(verdict(lump, "solid", "carbon steel", nullptr, 15 * steel), Verdict::NeedsReview);
  // 600 cm2 of 2 mm are 120 cm3.
  EXPECT_EQ(verdict(lump, "shell", "carbon steel", 2, 10.5 * steel), Verdict::Accepted);
  EXPECT_EQ(verdict(lump, "shell", "carbon steel", 2, 9.5 * steel), Verdict::NeedsReview);
  // Half of that if captured inside and outside; at most the enclosed volume.
  EXPECT_EQ(verdict(lump, "open_shell", "carbon steel", 2, 5.5 * steel), Verdict::Accepted);
  EXPECT_EQ(verdict(lump, "open_shell", "carbon steel", 2, 4.5 * steel), Verdict::NeedsReview);
  EXPECT_EQ(verdict(lump, "shell", "carbon steel", 200, 84 * steel), Verdict::Accepted);
  // No bound for walls without a thickness, contents, assemblies, materials that hold air, branching objects
  // and unresolved walls. A guessed scale lowers the bound to an eighth.
  for (const char* fill : {"shell", "open_shell", "filled", "assembly"})
    EXPECT_EQ(verdict(lump, fill, "carbon steel", nullptr, 2 * steel), Verdict::Accepted) << fill;
  for (const char* material : {"corrugated cardboard", "wicker", "leaf"})
    EXPECT_EQ(verdict(lump, "solid", material, nullptr, 2), Verdict::Accepted) << material;
  ObjectFacts other = lump;
  other.mesh.solidity = 0.6;
  EXPECT_EQ(verdict(other, "solid", "carbon steel", nullptr, 2 * steel), Verdict::Accepted);
  other = lump;
  other.mesh.mean_wall_m = 0.005;
  EXPECT_EQ(verdict(other, "solid", "carbon steel", nullptr, 2 * steel), Verdict::Accepted);
  other = lump;
  other.scale_known = false;
  EXPECT_EQ(verdict(other, "solid", "carbon steel", nullptr, 2 * steel), Verdict::Accepted);
  EXPECT_EQ(verdict(other, "solid", "carbon steel", nullptr, 1.9 * steel), Verdict::NeedsReview);
  // A skin of 0.1 mm on 0.92 m2 is the larger bound: more than a 64th of 5000 cm3.
  other = lump;
  other.mesh.size_m = other.mesh.box_m = {0.8, 0.3, 0.2};
  other.mesh.volume_m3 = 5e-3;
  other.mesh.area_m2 = 0.92;
  other.mesh.mean_wall_m = 0.05;
  EXPECT_EQ(verdict(other, "solid", "carbon steel", nullptr, 93 * steel), Verdict::Accepted);
  EXPECT_EQ(verdict(other, "solid", "carbon steel", nullptr, 91 * steel), Verdict::NeedsReview);
  other.mesh.area_m2 = 2;  // captured inside and outside, which counts once
  EXPECT_EQ(verdict(other, "solid", "carbon steel", nullptr, 93 * steel), Verdict::Accepted);
}

// Minimum masses of real objects: a takeaway cup of 11 g, a wicker basket, a teddy bear.
TEST(GatePrior, LightObjectsAreAccepted) {
  const auto asked = [](const char* name, const Eigen::Vector3d& size_m, double volume_m3, double area_m2,
                        double openness, const json& fields) {
    ObjectFacts facts;
    facts.name = name;
    facts.scale_known = true;
    facts.mesh.size_m = facts.mesh.principal_size_m = facts.mesh.box_m = size_m;
    facts.mesh.volume_m3 = volume_m3;
    facts.mesh.area_m2 = area_m2;
    facts.mesh.mean_wall_m = 2 * volume_m3 / area_m2;
    facts.mesh.openness = openness;
    facts.mesh.hull_volume_m3 = 0.7 * size_m.prod();
    facts.mesh.solidity = volume_m3 / facts.mesh.hull_volume_m3;
    facts.mesh.piece_count = 1;
    const json answer = with_fields(with_fields(mug_answer(), {{"name", name},
                                                               {"young_mpa", nullptr},
                                                               {"structure_s", nullptr},
                                                               {"plasticity", nullptr},
                                                               {"fragile", false}}),
                                    fields);
    const Judgement judgement = judge_answer(answer.dump(), facts, estimate_offline(facts));
    EXPECT_EQ(judgement.verdict, Verdict::Accepted) << name << ": " << judgement.message;
  };
  const auto walls = [](const char* material, double wall_mm) {
    json parts = all_of(material);
    parts[0]["thickness_mm"] = wall_mm;
    return parts;
  };
  // A cup with a 0.4 mm wall, drawn 3 mm thick; also of polypropylene.
  asked("paper cup", {0.09, 0.11, 0.09}, 9e-5, 0.06, 0.8,
        {{"parts", walls("paperboard", 0.5)}, {"mass_g", 11}});
  asked("plastic cup", {0.09, 0.11, 0.09}, 9e-5, 0.06, 0.8,
        {{"parts", walls("polypropylene", 1)}, {"mass_g", 12}});
  // 450 g, stated as 8 mm of weave; captured as if filled with air.
  asked("wicker basket", {0.4, 0.24, 0.3}, 6e-3, 0.9, 0.5,
        {{"parts", walls("wicker", 8)}, {"mass_g", 450}, {"behaviour", "elastic"}});
  // 26 x 20 x 18 cm; its cotton cover is stated as the material throughout.
  for (const auto& [material, s] : {std::pair("plush", 0.5), std::pair("cotton fabric", 0.001)}) {
    asked("teddy bear", {0.2, 0.26, 0.18}, 4.5e-3, 0.19, 0,
          {{"fill", "solid"},
           {"parts", all_of(material)},
           {"mass_g", 180},
           {"behaviour", "elastic"},
           {"structure_s", s}});
  }
  // A glass christmas ball: 8 cm, 0.8 mm wall, stated as 2 mm.
  asked("christmas ball", {0.08, 0.08, 0.08}, 2.6e-4, 0.02, 0,
        {{"fill", "shell"}, {"parts", walls("soda-lime glass", 2)}, {"mass_g", 28}, {"fragile", true}});
}

TEST(GatePrior, OtherMeaningsOfTheNameAreAccepted) {
  const json plain =
      with_fields(mug_answer(), {{"young_mpa", nullptr}, {"structure_s", nullptr}, {"fragile", false}});
  for (const char* material : {"stainless steel", "polypropylene"}) {
    const Judgement judgement = judge(with_fields(
        plain, {{"parts", all_of(material)}, {"mass_g", {{"low", 100}, {"best", 130}, {"high", 170}}}}));
    EXPECT_EQ(judgement.verdict, Verdict::Accepted) << material << ": " << judgement.message;
    EXPECT_EQ(judgement.parameters.material(), material);
  }
  EXPECT_EQ(judge(sponge_answer(), sponge_facts()).verdict, Verdict::Accepted);
  const Judgement nulls =
      judge(with_fields(sponge_answer(), {{"young_mpa", nullptr}, {"structure_s", nullptr}}), sponge_facts());
  EXPECT_EQ(nulls.verdict, Verdict::Accepted) << nulls.message;
  // Without a name the material is unknown.
  ObjectFacts unnamed = sponge_facts();
  unnamed.name = "";
  unnamed.scale_known = false;
  const Judgement soap = judge(with_fields(sponge_answer(), {{"name", "bar of soap"},
                                                             {"parts", all_of("bar soap")},
                                                             {"young_mpa", nullptr},
                                                             {"behaviour", "rigid"},
                                                             {"mass_g", 100}}),
                               unnamed);
  EXPECT_EQ(soap.verdict, Verdict::Accepted) << soap.message;
}

// The table's own values of each class, and of each other meaning of its name, are accepted.
TEST(GatePrior, EveryTableClassIsAcceptedUnderItsName) {
  for (const ObjectRow& row : object_table()) {
    std::vector<const ObjectRow*> kinds = {&row};
    for (const ObjectAlternative& other : row.alternatives) kinds.push_back(find_object_row(other.label));
    const ObjectFacts facts = facts_of_row(row, row.label);
    const auto offline = estimate_offline(facts);
    for (const ObjectRow* kind : kinds) {
      const auto as_kind = estimate_offline(facts_of_row(row, kind->label));
      const double mass_kg =
          std::clamp(as_kind.mass_kg().best(), offline.mass_kg().low(), offline.mass_kg().high());
      const json answer = answer_of_row(*kind, as_kind.behavior(), 1e3 * mass_kg);
      const Judgement judgement = judge_answer(answer.dump(), facts, offline);
      EXPECT_EQ(judgement.verdict, Verdict::Accepted)
          << row.label << " as " << kind->label << ": " << judgement.message;
    }
  }
}

}  // namespace
}  // namespace livegs

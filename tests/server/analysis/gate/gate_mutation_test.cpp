// SPDX-License-Identifier: Apache-2.0
// Corrupted answers through the gate: 20,000 by default, or LIVEGS_GATE_MUTATIONS.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "server/analysis/gate/answer_fixtures.h"
#include "server/analysis/gate/answer_mutations.h"
#include "server/analysis/gate/judge_answer.h"

namespace livegs {
namespace {

using v1::EstimatedValue;

void expect_within(const char* name, const EstimatedValue& value, ValueRange range) {
  ASSERT_TRUE(std::isfinite(value.low()) && std::isfinite(value.best()) && std::isfinite(value.high()))
      << name;
  if (value.source() != EstimatedValue::MODEL) return;
  ASSERT_LE(value.low(), value.best()) << name;
  ASSERT_LE(value.best(), value.high()) << name;
  ASSERT_GE(value.low(), range.low) << name;
  ASSERT_LE(value.high(), range.high) << name;
}

void expect_within_ranges(const v1::PhysicalParameters& p) {
  expect_within("mass_kg", p.mass_kg(), kMassRange_kg);
  expect_within("youngs_modulus_pa", p.youngs_modulus_pa(), kYoungsRange_pa);
  expect_within("structure_coefficient", p.structure_coefficient(), kStructureRange);
  expect_within("deformation_resistance", p.deformation_resistance(), kUnitRange);
  expect_within("plasticity", p.plasticity(), kUnitRange);
  expect_within("poisson_ratio", p.poisson_ratio(), {0, 0.49});
  expect_within("damping", p.damping(), {0, 2});
  expect_within("friction", p.friction(), kFrictionRange);
  expect_within("restitution", p.restitution(), kUnitRange);
  expect_within("wall_thickness_m", p.wall_thickness_m(), kWallRange_m);
  expect_within("break_impulse_n_s", p.break_impulse_n_s(), {0, 5 * kMassRange_kg.high});
  ASSERT_TRUE(p.behavior() == v1::Physics::RIGID || p.behavior() == v1::Physics::ELASTIC);
  ASSERT_TRUE(v1::Physics::Fill_IsValid(p.fill()));
  ASSERT_NE(find_material_row(p.material()), nullptr);
  ASSERT_LE(p.label().size(), 320u);
}

struct Case {
  ObjectFacts facts;
  nlohmann::json answer;
  v1::PhysicalParameters before;
};

std::vector<Case> spoiled_cases() {
  std::vector<Case> cases;
  cases.push_back({mug_facts(), mug_answer(), estimate_offline(mug_facts())});
  cases.push_back({pillow_facts(), pillow_answer(), estimate_offline(pillow_facts())});
  Case locked{mug_facts(), mug_answer(), estimate_offline(mug_facts())};
  locked.before.mutable_mass_kg()->set_source(EstimatedValue::PERSON);
  locked.before.mutable_friction()->set_source(EstimatedValue::SCENE);
  cases.push_back(locked);
  ObjectFacts unknown = pillow_facts();
  unknown.name = "";
  unknown.scale_known = false;
  cases.push_back({unknown, pillow_answer(), estimate_offline(unknown)});
  return cases;
}

Judgement judge_spoiled(const std::vector<Case>& cases, uint64_t seed) {
  const Case& one = cases[seed % cases.size()];
  return judge_answer(AnswerMutator(seed).mutate(one.answer), one.facts, one.before);
}

TEST(GateMutations, NoneLeavesTheRangesOrChangesALockedValue) {
  const std::vector<Case> cases = spoiled_cases();
  const char* asked = std::getenv("LIVEGS_GATE_MUTATIONS");
  const long count = asked ? std::atol(asked) : 20000;
  long verdicts[3] = {};
  for (long i = 0; i < count; ++i) {
    const Case& one = cases[static_cast<size_t>(i) % cases.size()];
    const Judgement judgement = judge_spoiled(cases, static_cast<uint64_t>(i));
    ++verdicts[static_cast<int>(judgement.verdict)];
    SCOPED_TRACE("seed " + std::to_string(i));
    ASSERT_NO_FATAL_FAILURE(expect_within_ranges(judgement.parameters));
    ASSERT_EQ(judgement.message.find('\n'), std::string::npos);
    ASSERT_LE(judgement.message.size(), 600u);
    if (judgement.verdict != Verdict::Refused) {
      ASSERT_NO_FATAL_FAILURE(expect_within_ranges(judgement.proposal));
    } else {
      ASSERT_FALSE(judgement.message.empty());
    }
    if (judgement.verdict == Verdict::Accepted && !one.facts.name.empty()) {
      ASSERT_EQ(judgement.parameters.behavior(), one.before.behavior());
    }
    if (const EstimatedValue& was = one.before.mass_kg();
        judgement.verdict == Verdict::Accepted && was.best() > 0) {
      const double kg = judgement.parameters.mass_kg().best();
      // Within 2.8 standard deviations, of which the range has 1.645 to each side, or within eight times.
      constexpr double beyond = 2.8 / 1.645;
      ASSERT_TRUE(std::abs(std::log(kg / was.best())) <= std::log(8.0) ||
                  (kg >= was.best() * std::pow(was.low() / was.best(), beyond) &&
                   kg <= was.best() * std::pow(was.high() / was.best(), beyond)))
          << kg << " for " << was.best();
    }
    if (judgement.verdict != Verdict::Accepted) {
      ASSERT_EQ(judgement.parameters.SerializeAsString(), one.before.SerializeAsString());
    }
    if (one.before.mass_kg().source() == EstimatedValue::PERSON) {
      ASSERT_EQ(judgement.parameters.mass_kg().SerializeAsString(), one.before.mass_kg().SerializeAsString());
      ASSERT_EQ(judgement.parameters.friction().SerializeAsString(),
                one.before.friction().SerializeAsString());
    }
  }
  // All three verdicts occur.
  EXPECT_GT(verdicts[0], count / 20);
  EXPECT_GT(verdicts[1], count / 2000);
  EXPECT_GT(verdicts[2], count / 20);
  RecordProperty("accepted", std::to_string(verdicts[0]));
  std::printf("%ld answers: %ld accepted, %ld for review, %ld refused\n", count, verdicts[0], verdicts[1],
              verdicts[2]);
}

// For any stated material, an accepted mug stays hard, and a sponge, pillow or tennis ball stays soft: E* is
// within a factor of 16 of such objects, which is 2.8 standard deviations of a pillow and of an answer about
// it, or within their range. Half of the scales are guessed.
TEST(GateMutations, NoneContradictsTheName) {
  std::mt19937_64 random(7);
  const auto below = [&](size_t count) { return static_cast<size_t>(random() % count); };
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const std::pair<ObjectFacts, nlohmann::json> things[] = {{mug_facts(), mug_answer()},
                                                           {sponge_facts(), sponge_answer()},
                                                           {pillow_facts(), pillow_answer()},
                                                           {tennis_ball_facts(), mug_answer()}};
  const auto& materials = material_table();
  long accepted = 0, review = 0;
  for (int i = 0; i < 8000; ++i) {
    auto [facts, answer] = things[below(std::size(things))];
    facts.scale_known = below(2) == 0;
    const auto offline = estimate_offline(facts);
    const auto change = [&] { return below(3) == 0; };
    if (change()) {
      answer["parts"] = nlohmann::json::array();
      double left = 1;
      for (size_t part = 0, count = 1 + below(3); part < count; ++part) {
        const double share = part + 1 == count ? left : left * unit();
        left -= share;
        answer["parts"].push_back(
            {{"name", "part"}, {"material_id", materials[below(materials.size())].name}, {"share", share}});
      }
    }
    if (change()) answer["behaviour"] = below(2) ? "rigid" : "elastic";
    if (change()) answer["fragile"] = below(2) == 0;
    if (change() || facts.name == "056_tennis_ball")
      answer["mass_g"] = 1e3 * offline.mass_kg().best() * std::exp(4 * (unit() - 0.5));
    if (below(2))
      answer["young_mpa"] = nullptr;
    else if (change()) {
      const double e = materials[below(materials.size())].youngs_modulus_pa.best * 1e-6;
      answer["young_mpa"] = {{"low", e / 2}, {"best", e}, {"high", e * 1.1}};
    }
    if (change())
      answer["structure_s"] = nullptr;
    else if (change())
      answer["structure_s"] = std::max(1e-3, std::exp(-7 * unit()));
    const Judgement judgement = judge_answer(answer.dump(), facts, offline);
    accepted += judgement.verdict == Verdict::Accepted;
    review += judgement.verdict == Verdict::NeedsReview;
    if (judgement.verdict != Verdict::Accepted) continue;
    SCOPED_TRACE(std::to_string(i) + " " + answer.dump());
    const v1::PhysicalParameters& p = judgement.parameters;
    ASSERT_EQ(p.behavior(), offline.behavior());
    const double stiffness_pa = p.youngs_modulus_pa().best() * p.structure_coefficient().best();
    const auto& e = offline.youngs_modulus_pa();
    const auto& s = offline.structure_coefficient();
    if (offline.behavior() == v1::Physics::RIGID) {
      ASSERT_GT(stiffness_pa, 200e6 / 16);  // the softest possible mug is plastic
    } else {
      ASSERT_GE(stiffness_pa, std::min(e.low() * s.low(), e.best() * s.best() / 16) * 0.999);
      ASSERT_LE(stiffness_pa, std::max(e.high() * s.high(), e.best() * s.best() * 16) * 1.001);
    }
  }
  EXPECT_GT(accepted, 800);
  EXPECT_GT(review, 800);
}

// Regression: the thinnest wall, 0.01 mm, whose range extended below the limit.
TEST(GateMutations, ThinnestWallStaysWithinTheRanges) {
  const Judgement judgement = judge_spoiled(spoiled_cases(), 1145262);
  ASSERT_NE(judgement.verdict, Verdict::Refused) << judgement.message;
  EXPECT_EQ(judgement.proposal.wall_thickness_m().low(), kWallRange_m.low);
  expect_within_ranges(judgement.proposal);
}

}  // namespace
}  // namespace livegs

// SPDX-License-Identifier: Apache-2.0
#include "server/analysis/gate/replayed_answers.h"

#include <cmath>

#include "server/analysis/gate/judge_answer.h"

namespace livegs {

nlohmann::json replayed_answer(const std::string& name, double true_kg, const ObjectFacts& facts,
                               std::mt19937_64& random) {
  ObjectFacts named = facts;
  named.name = name;
  const v1::PhysicalParameters known = estimate_offline(named);
  // The sum of twelve uniform numbers is close to normal, and the same for any standard library.
  double normal = -6;
  for (int i = 0; i < 12; ++i) normal += static_cast<double>(random() >> 11) * 0x1p-53;
  const double best_g = 1e3 * true_kg * std::exp(kAnswerSd * normal), spread = std::exp(1.645 * kAnswerSd);
  return with_fields(mug_answer(),
                     {{"name", name},
                      {"fill", "assembly"},
                      {"parts", all_of(known.material())},
                      {"behaviour", known.behavior() == v1::Physics::RIGID ? "rigid" : "elastic"},
                      {"mass_g", {{"low", best_g / spread}, {"best", best_g}, {"high", best_g * spread}}},
                      {"young_mpa", nullptr},
                      {"structure_s", nullptr},
                      {"plasticity", nullptr},
                      {"fragile", false}});
}

std::vector<MassAnswer> replay_answers(const std::vector<KnownObject>& objects, NameGiven name, int repeats) {
  std::mt19937_64 random(34);
  std::vector<MassAnswer> answers;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (const KnownObject& object : objects) {
      ObjectFacts facts = object.facts;
      facts.name = name == NameGiven::Label ? object.label : "thing";
      const nlohmann::json answer = replayed_answer(name == NameGiven::Label ? object.label : object.noun,
                                                    object.mass_kg, facts, random);
      const Judgement judgement = judge(answer, facts);
      const auto& mass = judgement.parameters.mass_kg();
      answers.push_back({object.id, object.mass_kg, mass.low(), mass.best(), mass.high()});
    }
  }
  return answers;
}

}  // namespace livegs

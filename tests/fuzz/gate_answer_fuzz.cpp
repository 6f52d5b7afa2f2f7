// SPDX-License-Identifier: Apache-2.0
// A model's answer through the acceptance gate. The first byte chooses the object it is about; the rest is
// the answer. Nothing leaves the hard ranges, and nothing but an accepted answer changes anything, nor that
// what a person has told.
#include <cmath>

#include "fuzz/fuzz_target.h"
#include "server/analysis/gate/answer_fixtures.h"
#include "server/analysis/gate/answer_mutations.h"
#include "server/analysis/gate/judge_answer.h"

namespace livegs::fuzz::gate_answer_fuzz {
namespace {

using v1::EstimatedValue;

struct Object {
  ObjectFacts facts;
  v1::PhysicalParameters before;
};
const std::vector<Object>& objects() {
  static const std::vector<Object> all = [] {
    std::vector<Object> made;
    for (const ObjectFacts& facts : {mug_facts(), pillow_facts()})
      made.push_back({facts, estimate_offline(facts)});
    made.push_back(made[0]);
    made.back().before.mutable_mass_kg()->set_source(EstimatedValue::PERSON);
    made.back().before.mutable_friction()->set_source(EstimatedValue::SCENE);
    ObjectFacts unknown = pillow_facts();
    unknown.name = "";
    unknown.scale_known = false;
    made.push_back({unknown, estimate_offline(unknown)});
    return made;
  }();
  return all;
}

void check_within(const EstimatedValue& value, ValueRange range, const char* name) {
  check(std::isfinite(value.low()) && std::isfinite(value.best()) && std::isfinite(value.high()), name);
  if (value.source() != EstimatedValue::MODEL) return;
  check(value.low() <= value.best() && value.best() <= value.high(), name);
  check(value.low() >= range.low && value.high() <= range.high, name);
}

void check_ranges(const v1::PhysicalParameters& p) {
  check_within(p.mass_kg(), kMassRange_kg, "mass_kg");
  check_within(p.youngs_modulus_pa(), kYoungsRange_pa, "youngs_modulus_pa");
  check_within(p.structure_coefficient(), kStructureRange, "structure_coefficient");
  check_within(p.deformation_resistance(), kUnitRange, "deformation_resistance");
  check_within(p.plasticity(), kUnitRange, "plasticity");
  check_within(p.friction(), kFrictionRange, "friction");
  check_within(p.restitution(), kUnitRange, "restitution");
  check_within(p.wall_thickness_m(), kWallRange_m, "wall_thickness_m");
  check(p.behavior() == v1::Physics::RIGID || p.behavior() == v1::Physics::ELASTIC, "behavior");
  check(v1::Physics::Fill_IsValid(p.fill()), "fill");
  check(p.label().size() <= 320, "label");
}

bool same(const google::protobuf::Message& a, const google::protobuf::Message& b) {
  return a.SerializeAsString() == b.SerializeAsString();
}

Bytes input(size_t object, const std::string& text) {
  Bytes bytes{static_cast<std::byte>(object)};
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

}  // namespace

void look_at(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  const Object& object = objects()[std::to_integer<size_t>(bytes[0]) % objects().size()];
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()) + 1, bytes.size() - 1);
  const Judgement judgement = judge_answer(text, object.facts, object.before);
  check_ranges(judgement.parameters);
  if (judgement.verdict != Verdict::Refused) check_ranges(judgement.proposal);
  if (judgement.verdict != Verdict::Accepted)
    check(same(judgement.parameters, object.before), "it changes nothing");
  check(judgement.message.find('\n') == std::string::npos && judgement.message.size() <= 600,
        "a message is one line");
  if (object.before.mass_kg().source() == EstimatedValue::PERSON) {
    check(same(judgement.parameters.mass_kg(), object.before.mass_kg()), "what a person told stays");
    check(same(judgement.parameters.friction(), object.before.friction()), "what the scene told stays");
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> seeds;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const nlohmann::json answer = seed % 4 % 2 ? pillow_answer() : mug_answer();
    seeds.push_back(input(seed % 4, seed < 4 ? answer.dump() : AnswerMutator(seed).mutate(answer)));
  }
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"gate_answer", look_at, seeds});

}  // namespace livegs::fuzz::gate_answer_fuzz

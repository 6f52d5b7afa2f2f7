// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "analysis/division/divide_by_looks.h"
#include "analysis/estimate.h"
#include "analysis/estimate/class_mass.h"
#include "analysis/estimate/object_classes.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/estimate/stiffness_classes.h"
#include "analysis/knowledge/tables.h"
#include "core/text/format_text.h"

// Precedence: label, then geometry, then colour. A name with table priors halves the error of geometry alone,
// and hollowness matters more than density. object_classes and class_mass use this order. Every value has a
// reason.

namespace livegs {
namespace {

using v1::EstimatedValue;

void set(EstimatedValue& value, const Span3& span, std::string reason) {
  value.set_low(std::min(span.low, span.best));
  value.set_best(span.best);
  value.set_high(std::max(span.high, span.best));
  value.set_source(EstimatedValue::OFFLINE);
  value.set_reason(std::move(reason));
}

// A judgement with a relative spread, clamped to [low, high].
Span3 around(double best, double spread, double low, double high) {
  return {std::max(low, best * (1 - spread)), best, std::min(high, best * (1 + spread))};
}

// Assumed class of the object, and the reason.
struct Guess {
  ObjectClass kind;
  const MaterialRow* material = nullptr;
  Span3 wall_m;
  double confidence = 0;
  std::string reason;
};

Guess guess_by_name(const ObjectClasses& kinds, const ObjectFacts& facts) {
  Guess guess;
  guess.kind = kinds.kinds.front();
  const std::string& label = guess.kind.row->label;
  guess.material = guess.kind.material ? guess.kind.material : &material_row(guess.kind.row->material);
  guess.wall_m = guess.kind.row->wall_m;
  guess.confidence = (kinds.material.row ? 0.6 : 0.55) * (0.5 + 0.5 * guess.kind.probability);
  guess.reason = format_text("the name \"%s\" means %s; ", facts.name.c_str(), kinds.match.alias.c_str());
  if (label == kinds.match.row->label) {
    guess.reason +=
        format_text("a %s is usually %s", kinds.match.alias.c_str(), guess.material->name.c_str());
  } else {
    guess.reason += format_text("its size and shape are those of a %s, usually %s", label.c_str(),
                                guess.material->name.c_str());
  }
  if (kinds.match.tail == NameMatch::Tail::Unknown) {
    guess.reason += format_text("; the meaning of \"%s\" there is unknown", kinds.match.tail_words.c_str());
    guess.confidence *= 0.7;
  }
  if (guess.kind.probability < 0.995) guess.reason += format_text(" (%.0f %%)", 100 * guess.kind.probability);
  return guess;
}

// The median, by stiffness, of the materials of the likely classes that do not break: the smallest error if
// nothing speaks for one of them.
const MaterialRow* middle_material(const ObjectClasses& kinds) {
  std::vector<std::pair<double, const MaterialRow*>> weights;  // sorted by stiffness below
  double total = 0;
  for (const ObjectClass& kind : kinds.kinds) {
    const MaterialRow& material = kind.material ? *kind.material : material_row(kind.row->material);
    if (material.fragile) continue;
    weights.emplace_back(kind.probability, &material);
    total += kind.probability;
  }
  std::stable_sort(weights.begin(), weights.end(), [](const auto& a, const auto& b) {
    return a.second->youngs_modulus_pa.best < b.second->youngs_modulus_pa.best;
  });
  for (const auto& [weight, material] : weights) {
    total -= 2 * weight;
    if (total <= 0) return material;
  }
  return nullptr;
}

// Material shared by the likely classes, and the likeliest class.
Guess guess_by_looks(const ObjectClasses& kinds, const ObjectFacts& facts) {
  Guess guess;
  double best = -1;
  for (const ObjectClass& kind : kinds.kinds) {
    const std::string& material = kind.material ? kind.material->name : kind.row->material;
    double together = 0;
    for (const ObjectClass& other : kinds.kinds) {
      if ((other.material ? other.material->name : other.row->material) == material)
        together += other.probability;
    }
    if (together <= best) continue;
    best = together;
    guess.kind = kind;
    guess.material = &material_row(material);
  }
  guess.wall_m = guess.kind.row->wall_m;
  guess.confidence = 0.1 + 0.25 * best;
  guess.reason =
      format_text("unknown name; among things of this size and shape, like a %s, %.0f %% are made of it",
                  guess.kind.row->label.c_str(), 100 * best);
  if (kinds.match.row) {
    guess.reason = format_text(
        "\"%s\" is unknown, and \"%s\" is only part of the name; among things of this size and shape, like a "
        "%s, %.0f %% are made of it",
        facts.name.c_str(), kinds.match.alias.c_str(), guess.kind.row->label.c_str(), 100 * best);
  }
  if (kinds.material.row && guess.material->material_class == kinds.material.row->material_class) {
    guess.confidence = kMaterialNamedConfidence;
    guess.reason = format_text("the name \"%s\" means %s", facts.name.c_str(), guess.material->name.c_str());
  } else if (const double trust = facts.scale_known ? 1.0 : kGuessedScaleTrust;
             trust * guess.confidence < kMinMaterialConfidence) {
    if (const MaterialRow* middle = middle_material(kinds)) {
      guess.material = middle;
      guess.reason = format_text(
          "unknown; %s is the median of the materials of unbreakable objects of this size and shape",
          middle->name.c_str());
    }
  }
  return guess;
}

// Sets the parts of an object of several materials, with their places if its looks show them; shares are
// fractions of its mass.
void set_parts(const ObjectClass& kind, const ObjectFacts& facts, v1::PhysicalParameters& answer) {
  for (const ObjectPart& part : kind.row->parts) {
    add_material_part(answer, part.name, part.material, part.mass_share);
  }
  if (kind.row->parts.empty()) return;
  answer.set_parts_source(EstimatedValue::OFFLINE);
  if (facts.kernels) {
    answer.set_parts_reason(divide_by_looks(kind.row->parts, *facts.kernels, *answer.mutable_parts()).reason);
  } else {
    answer.set_parts_reason("one part: it was not captured");
  }
}

}  // namespace

v1::PhysicalParameters estimate_offline(const ObjectFacts& facts) {
  v1::PhysicalParameters answer;
  const ObjectClasses kinds = object_classes(facts);
  const bool by_name = kinds.match.row && kinds.match.tail != NameMatch::Tail::AnotherThing;
  const Guess guess = by_name ? guess_by_name(kinds, facts) : guess_by_looks(kinds, facts);
  const ObjectRow& row = *guess.kind.row;
  const MaterialRow& material = *guess.material;
  answer.set_label(by_name ? kinds.match.alias : "object");
  answer.set_material(material.name);
  answer.set_confidence(facts.scale_known ? guess.confidence : kGuessedScaleTrust * guess.confidence);
  answer.set_fragile(material.fragile);
  const Span3 wall_m = facts.solid ? Span3{} : guess.wall_m;
  answer.set_fill(facts.solid ? v1::Physics::SOLID : row.fill);
  answer.set_fill_reason(facts.solid ? "shapes and points are solid unless the scene has another fill"
                         : by_name
                             ? format_text("a %s usually is", row.label.c_str())
                             : format_text("as a %s is; openness %.2f, filled share of the hull %.2f",
                                           row.label.c_str(), facts.mesh.openness, facts.mesh.solidity));
  if (!facts.solid && by_name) set_parts(guess.kind, facts, answer);

  const Span3 structure = row.structure_coefficient;
  const Span3 stiffness{structure.low * material.youngs_modulus_pa.low,
                        structure.best * material.youngs_modulus_pa.best,
                        structure.high * material.youngs_modulus_pa.high};
  const bool soft = is_soft_class(material.material_class);
  const bool rigid = stiffness.best > kRigidStiffness_pa || (stiffness.best > kStiffStiffness_pa && !soft);
  answer.set_behavior(rigid ? v1::Physics::RIGID : v1::Physics::ELASTIC);
  answer.set_behavior_reason(
      format_text("E* = s E = %.3g %s, %s", stiffness.best * (stiffness.best < 1e9 ? 1e-6 : 1e-9),
                  stiffness.best < 1e9 ? "MPa" : "GPa",
                  rigid ? "too stiff to deform visibly" : "soft enough to deform visibly"));

  set(*answer.mutable_wall_thickness_m(), wall_m,
      wall_m.best > 0 ? format_text("%s; the mesh's mean wall is %.3g mm",
                                    by_name ? "usual for its kind" : "a guess", facts.mesh.mean_wall_m * 1e3)
                      : "not a shell");
  const MassEstimate mass = mass_of_classes(kinds, facts);
  set(*answer.mutable_mass_kg(), mass.mass_kg, mass.reason);
  const std::string of_material = format_text("%s; %s", material.name.c_str(), guess.reason.c_str());
  set(*answer.mutable_youngs_modulus_pa(), material.youngs_modulus_pa, of_material);
  set(*answer.mutable_poisson_ratio(), around(material.poisson_ratio, 0.1, 0.0, 0.49), material.name);
  set(*answer.mutable_structure_coefficient(), structure,
      structure.best < 1 ? "thin or hollow things bend more easily than their material" : "bulk");
  set(*answer.mutable_plasticity(), around(material.plasticity, 0.4, 0.0, 1.0),
      format_text("%s; keeps a dent like %s", material.name.c_str(),
                  nearest_plasticity_level(material.plasticity).text().c_str()));
  set(*answer.mutable_damping(), around(material.loss_factor, 0.5, 0.0, 2.0),
      format_text("loss factor of %s", material.material_class.c_str()));
  set(*answer.mutable_friction(), around(material.friction, 0.3, 0.0, 2.0),
      format_text("%s on common surfaces", material.name.c_str()));
  set(*answer.mutable_restitution(), around(material.restitution, 0.3, 0.0, 1.0),
      format_text("%s on a hard floor", material.name.c_str()));
  set(*answer.mutable_deformation_resistance(),
      {deformation_resistance(stiffness.low), deformation_resistance(stiffness.best),
       deformation_resistance(stiffness.high)},
      "from E* = s E by the paper's map");
  set_inside(material, answer);
  if (answer.fragile()) {
    // Drop heights of 0.2, 0.5 and 1.2 m onto a hard floor: the range in which such objects usually break.
    const double mass_kg = answer.mass_kg().best();
    set(*answer.mutable_break_impulse_n_s(), {2.0 * mass_kg, 3.1 * mass_kg, 4.9 * mass_kg},
        format_text("%s things break in falls of about half a metre", material.material_class.c_str()));
  }
  return answer;
}

}  // namespace livegs

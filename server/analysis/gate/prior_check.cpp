// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/prior_check.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/estimate/object_classes.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/estimate/stiffness_classes.h"
#include "analysis/gate/mass_bounds.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

using v1::EstimatedValue;
using v1::Physics;

constexpr double kMaxPriorRatio = 8.0;
// Parts below these shares of the mass are not structural, or not named.
constexpr double kMinStructuralShare = 0.05, kMinNamedPriorShare = 0.1;

Span3 product(const Span3& a, const Span3& b) { return {a.low * b.low, a.best * b.best, a.high * b.high}; }

bool far(double value, const Span3& prior) {
  const bool within = value >= prior.low && value <= prior.high;
  return !within && !(std::abs(std::log(value / prior.best)) <= std::log(kMaxPriorRatio));
}

// A possible meaning of the name.
struct KnownKind {
  std::vector<std::string> classes;  // of its material, then of its parts
  Span3 stiffness_pa;                // E* = s E
};

void add_class(KnownKind& kind, std::string_view material) {
  if (const MaterialRow* row = find_material_row(material)) kind.classes.push_back(row->material_class);
}

bool means(const ObjectRow& name, const ObjectRow& thing) {
  return &name == &thing || std::any_of(name.alternatives.begin(), name.alternatives.end(),
                                        [&](const auto& other) { return other.label == thing.label; });
}

// Possible meanings of the name; empty if the name is unknown. The scale is ignored because it changes the
// mass, not the material.
std::vector<KnownKind> known_kinds(const ObjectClasses& found, const ObjectFacts& facts,
                                   const v1::PhysicalParameters& offline) {
  const bool named = found.match.row && found.match.tail == NameMatch::Tail::Nothing;
  const double least_confidence = (facts.scale_known ? 1 : kGuessedScaleTrust) * kMaterialNamedConfidence;
  if (!named && offline.confidence() < least_confidence) return {};
  std::vector<KnownKind> known;
  KnownKind own;
  add_class(own, offline.material());
  for (const v1::MaterialPart& part : offline.parts()) add_class(own, part.material());
  own.stiffness_pa = product(span_of(offline.structure_coefficient()), span_of(offline.youngs_modulus_pa()));
  if (own.stiffness_pa.best > 0 && !own.classes.empty()) known.push_back(std::move(own));
  if (!found.match.row || found.match.tail == NameMatch::Tail::AnotherThing) return known;

  const auto material_of = [](const ObjectClass& kind) -> const MaterialRow& {
    return kind.material ? *kind.material : material_row(kind.row->material);
  };
  // "wooden bowl" excludes steel bowls and keeps all bowls of wood.
  const auto of_named_material = [&](const ObjectClass& kind) {
    return found.material.row && material_of(kind).material_class == found.material.row->material_class;
  };
  const bool any_of_named_material = std::any_of(found.kinds.begin(), found.kinds.end(), of_named_material);
  for (const ObjectClass& kind : found.kinds) {
    if (found.kinds.size() > 1 && !means(*found.match.row, *kind.row)) continue;  // added by appearance
    if (any_of_named_material && !of_named_material(kind)) continue;
    KnownKind one;
    one.classes.push_back(material_of(kind).material_class);
    for (const ObjectPart& part : kind.row->parts) add_class(one, part.material);
    one.stiffness_pa = product(kind.row->structure_coefficient, material_of(kind).youngs_modulus_pa);
    known.push_back(std::move(one));
  }
  return known;
}

// True if the materials fit one of the known classes. An assembly may have any material. A hard material may
// replace another hard one, and a soft one another soft one, if the answer agrees on the class.
bool material_fits(const Answer& answer, const ObjectClasses& found, const std::vector<KnownKind>& known) {
  const auto fits = [&](const std::string& material_class, bool agreed) {
    for (const KnownKind& kind : known) {
      for (const std::string& one : kind.classes) {
        if (one == material_class || one == "assembly") return true;
      }
      if (agreed && is_soft_class(material_class) == is_soft_class(kind.classes.front())) return true;
    }
    return false;
  };
  const auto any = [&](bool agreed) {
    for (const AnswerPart& part : answer.parts) {
      if (&part != &answer.parts.front() && part.share < kMinNamedPriorShare) break;
      if (fits(part.material->material_class, agreed)) return true;
    }
    return false;
  };
  if (any(false)) return true;
  if (!found.match.row) return false;
  const NameMatch named = match_name(answer.name);
  const bool agreed =
      named.row && (means(*found.match.row, *named.row) || means(*named.row, *found.match.row));
  return agreed && any(true);
}

// A rigid object needs a rigid structural part; a small stoneware part in foam is not structural.
std::string rigid_at_odds(const Answer& answer, const v1::PhysicalParameters& proposal) {
  if (proposal.behavior() != Physics::RIGID) return "";
  double young = 0;
  if (is_locked(proposal.youngs_modulus_pa())) {
    young = proposal.youngs_modulus_pa().best();
  } else if (answer.youngs_modulus_pa) {
    young = answer.youngs_modulus_pa->best;
  } else {
    for (const AnswerPart& part : answer.parts) {
      if (&part == &answer.parts.front() || part.share >= kMinStructuralShare)
        young = std::max(young, part.material->youngs_modulus_pa.best);
    }
  }
  const double stiffness = young * (answer.structure_coefficient ? answer.structure_coefficient->best : 1.0);
  if (!(stiffness < kSoftStiffness_pa)) return "";
  return format_text(
      "behaviour: rigid does not fit s E = %.3g MPa of %s, which a hand deforms (below %g MPa)",
      stiffness * 1e-6, materials_of(answer).c_str(), kSoftStiffness_pa * 1e-6);
}

std::string behaviour_far(const v1::PhysicalParameters& proposal, const v1::PhysicalParameters& offline,
                          const std::vector<KnownKind>& known) {
  const bool rigid = proposal.behavior() == Physics::RIGID;
  if (proposal.behavior() == offline.behavior()) return "";
  for (const KnownKind& kind : known) {
    if (rigid ? kind.stiffness_pa.best >= kSoftStiffness_pa : kind.stiffness_pa.best <= kRigidStiffness_pa)
      return "";
  }
  return format_text("behaviour: %s, but an object called \"%s\" is %s, with s E = %.3g MPa",
                     rigid ? "rigid" : "elastic", offline.label().c_str(), rigid ? "elastic" : "rigid",
                     known.front().stiffness_pa.best * 1e-6);
}

// Compares E* = s E, because a thin structure and a soft material are interchangeable.
std::string stiffness_far(const Answer& answer, const v1::PhysicalParameters& proposal,
                          const std::vector<KnownKind>& known) {
  const EstimatedValue& young = proposal.youngs_modulus_pa();
  const EstimatedValue& structure = proposal.structure_coefficient();
  if (is_locked(young) && is_locked(structure)) return "";
  const auto fits = [&](double stiffness_pa) {
    return std::any_of(known.begin(), known.end(), [&](const KnownKind& kind) {
      const double stiff = is_soft_class(kind.classes.front()) ? kRigidStiffness_pa : kStiffStiffness_pa;
      return (stiffness_pa > kRigidStiffness_pa && kind.stiffness_pa.best > stiff) ||
             !far(stiffness_pa, kind.stiffness_pa);
    });
  };
  const double s = structure.best() > 0 ? structure.best() : 1.0;
  const double fused = young.best() * s;
  const double answered_pa =
      answer.youngs_modulus_pa && !is_locked(young) ? answer.youngs_modulus_pa->best * s : fused;
  for (const double one : {answered_pa, fused}) {
    if (fits(one)) continue;
    return format_text(
        "%s: s E = %.3g MPa is more than %g times away from the %.3g MPa that its kind suggests",
        answer.youngs_modulus_pa ? "young_mpa.best" : "structure_s", one * 1e-6, kMaxPriorRatio,
        known.front().stiffness_pa.best * 1e-6);
  }
  return "";
}

}  // namespace

std::string check_prior(const Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                        const v1::PhysicalParameters& proposal) {
  const EstimatedValue& mass = offline.mass_kg();
  if (!is_locked(mass)) {
    if (mass.best() > 0 && far(answer.mass_kg.best, span_of(mass))) {
      return format_text(
          "mass_g.best: %.4g g is more than %g times away from the %.4g g that size and kind suggest",
          answer.mass_kg.best * 1e3, kMaxPriorRatio, mass.best() * 1e3);
    }
    if (auto why = mass_at_odds(answer, facts); !why.empty()) return why;
  }
  if (auto why = rigid_at_odds(answer, proposal); !why.empty()) return why;
  const ObjectClasses found = object_classes(facts);
  const std::vector<KnownKind> known = known_kinds(found, facts, offline);
  if (known.empty()) return "";
  if (auto why = behaviour_far(proposal, offline, known); !why.empty()) return why;
  if (!material_fits(answer, found, known)) {
    return format_text("parts: %s, but an object called \"%s\" is made of %s", materials_of(answer).c_str(),
                       offline.label().c_str(), offline.material().c_str());
  }
  return stiffness_far(answer, proposal, known);
}

}  // namespace livegs

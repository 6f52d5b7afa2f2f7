// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/fuse_answer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "analysis/division/divide_by_looks.h"
#include "analysis/division/picture_votes.h"
#include "analysis/estimate/class_mass.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/gate/answer_parts.h"
#include "analysis/knowledge/name_match.h"
#include "core/text/format_text.h"
#include "physics/material.h"

namespace livegs {
namespace {

using v1::EstimatedValue;
using v1::Physics;

// A 90 % range is 1.645 standard deviations to each side. Models give ranges that are too narrow: a range is
// not narrower than 10 % in mass, and a single number counts as uncertain by a third.
constexpr double kRangeDeviations = 3.29;
constexpr double kMinDeviation = 0.10, kSingleValueDeviation = 0.33;
constexpr double kMaxConfidence = 0.95;
// Friction and restitution vary more between sources than rubber or wood does between pieces.
constexpr double kLinearSpread = 0.15;

// Sets a value, clamped to `hard`. All widened, fused and voted values pass through this function.
void set(EstimatedValue& value, const Span3& span, ValueRange hard, std::string reason) {
  const auto kept = [&](double one) { return std::clamp(one, hard.low, hard.high); };
  value.set_low(kept(std::min(span.low, span.best)));
  value.set_best(kept(span.best));
  value.set_high(kept(std::max(span.high, span.best)));
  value.set_source(EstimatedValue::MODEL);
  value.set_reason(std::move(reason));
}

double deviation(const Span3& span) {
  if (!(span.low > 0) || span.high <= span.low) return kSingleValueDeviation;
  return std::max(kMinDeviation, std::log(span.high / span.low) / kRangeDeviations);
}

Span3 range_of(const LogNormal& value) {
  const double half = 0.5 * kRangeDeviations * value.sd;
  return {std::exp(value.mean_ln - half), std::exp(value.mean_ln), std::exp(value.mean_ln + half)};
}

// Mass of things of this name at the measured size, one component for each class that the name may mean; none
// if the tables do not have the name. The name is that of the answer: a prior of the appearance alone was
// made without the pictures, and a prior of another thing is wrong.
std::vector<WeightedLogNormal> prior_of(const ObjectClasses& classes, const ObjectFacts& facts) {
  std::vector<WeightedLogNormal> prior;
  if (!is_named(classes)) return prior;
  for (const ObjectClass& one : classes.kinds) prior.push_back({one.probability, kind_mass(one, facts).mass});
  return prior;
}

// Adds the posterior after the answer: each class is weighted by how well it predicts the answer. The weights
// sum to `probability`. Returns the mean of ln(mass) if the answer is not wrong: a mean of two values that
// contradict each other is the value of neither.
double add_posterior(const LogNormal& answered, std::span<const WeightedLogNormal> prior, double probability,
                     std::vector<WeightedLogNormal>& mixture) {
  if (prior.empty()) {
    mixture.push_back({probability, answered});
    return answered.mean_ln;
  }
  const size_t first = mixture.size();
  double sum = 0;
  std::vector<WeightedLogNormal> right;
  for (const WeightedLogNormal& one : prior) {
    auto components = fused_mixture(answered, one.value, kErrorCorrelation);
    for (WeightedLogNormal& component : components) {
      component.weight *= one.weight;
      sum += component.weight;
      mixture.push_back(component);
    }
    right.push_back(components[0]);
    right.push_back(components[2]);
  }
  for (size_t i = first; i < mixture.size(); ++i) mixture[i].weight *= probability / sum;
  return mixture_mean_ln(right);
}

struct FusedMass {
  Span3 mass_kg;
  std::string reason;
};

// The alternatives of the answer, each fused with the prior of its own name, as one mixture. The best value
// is that of the most probable alternative, not a mean between a toy and the real thing.
FusedMass fused_mass(const Answer& answer, const ObjectFacts& facts) {
  std::vector<MassAlternative> alternatives = answer.alternatives;
  if (alternatives.empty()) alternatives.push_back({answer.name, 1, answer.mass_kg});
  std::vector<WeightedLogNormal> mixture;
  double highest = 0, best = answer.mass_kg.best;
  FusedMass fused;
  for (const MassAlternative& one : alternatives) {
    const std::vector<WeightedLogNormal> prior = prior_of(answered_classes(answer, one.name, facts), facts);
    const double mean_ln = add_posterior(log_normal_of(one.mass_kg), prior, one.probability, mixture);
    if (one.probability <= highest) continue;
    highest = one.probability;
    best = std::exp(mean_ln);
    fused.reason = format_text("%.4g g by the model", one.mass_kg.best * 1e3);
    if (!prior.empty())
      fused.reason += format_text(", %.4g g usual for \"%s\" of this size",
                                  std::exp(mixture_mean_ln(prior)) * 1e3, one.name.c_str());
    if (alternatives.size() > 1) fused.reason += format_text(", with %.0f %%", 100 * one.probability);
    fused.reason += "; ";
  }
  fused.mass_kg = {std::min(best, std::exp(mixture_quantile_ln(mixture, 0.05))), best,
                   std::max(best, std::exp(mixture_quantile_ln(mixture, 0.95)))};
  return fused;
}

Span3 around(double best) { return {best * (1 - kLinearSpread), best, best * (1 + kLinearSpread)}; }

std::string model_says(const Answer& answer) {
  if (answer.evidence.empty()) return "the model's judgement";
  return (answer.blind ? "the model, without pictures: " : "the model saw: ") + answer.evidence;
}

// Wall thickness of the part with most of a shell's mass.
std::optional<double> wall_of(const Answer& answer, const ObjectFacts& facts) {
  for (const AnswerPart& part : answer.parts) {
    if (!part.thickness_m) continue;
    const double thinnest = facts.mesh.size_m.minCoeff();
    return thinnest > 0 ? std::min(*part.thickness_m, 0.5 * thinnest) : *part.thickness_m;
  }
  return std::nullopt;
}

// Index of the part that encloses each part, by its name.
std::vector<std::optional<PartHolder>> holders_of(const std::vector<AnswerPart>& parts) {
  std::vector<std::optional<PartHolder>> holders(parts.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    for (size_t k = 0; k < parts.size() && !parts[i].inside.empty(); ++k) {
      // One level is enough; a part cannot be enclosed by what it encloses.
      if (k != i && parts[k].inside.empty() &&
          normalised_name(parts[k].name) == normalised_name(parts[i].inside)) {
        holders[i] = PartHolder{k, false};
        break;
      }
    }
  }
  return holders;
}

// Divides the object at the places that parts of a thing of this name usually have, if the answer has the
// same parts: by name, else by class of material. Puts them into the order of the table.
std::string divide_by_usual_places(const std::string& name, const SurfaceKernels& kernels,
                                   MaterialParts& parts) {
  const std::string unmarked = "one part: the model marked no parts on the pictures";
  const ObjectRow* row = match_name(name).row;
  if (!row || row->parts.size() != static_cast<size_t>(parts.size())) return unmarked;
  const auto class_of = [](const std::string& material) {
    const MaterialRow* found = find_material_row(material);
    return found ? found->material_class : "";
  };
  MaterialParts ordered, left = parts;
  for (const ObjectPart& usual : row->parts) {
    int same = -1;
    for (int i = 0; i < left.size(); ++i) {
      if (normalised_name(left[i].name()) == normalised_name(usual.name)) same = i;
    }
    for (int i = 0; i < left.size() && same < 0; ++i) {
      if (class_of(left[i].material()) == class_of(usual.material)) same = i;
    }
    if (same < 0) return unmarked;
    *ordered.Add() = left[same];
    left.DeleteSubrange(same, 1);
  }
  const LooksDivision division = divide_by_looks(row->parts, kernels, ordered);
  if (division.divided) parts = std::move(ordered);
  return division.reason;
}

// Takes the parts of the answer, even if there are none: the estimate's parts belong to the class assumed
// there. Their places follow from the boxes on the pictures; without boxes, from the looks of such things.
void set_parts(const Answer& answer, const ObjectFacts& facts, v1::PhysicalParameters& result,
               std::vector<std::string>& changes) {
  if (result.parts_source() == EstimatedValue::SCENE || result.parts_source() == EstimatedValue::PERSON)
    return;
  result.clear_parts();
  result.clear_parts_reason();
  result.set_parts_source(EstimatedValue::SOURCE_UNKNOWN);
  if (answer.parts.size() < 2) return;
  std::vector<AnswerPart> parts = answer.parts;
  limit_parts(parts, static_cast<size_t>(kMaxMaterialParts), changes);
  // Places are read in order: what is enclosed comes after its holder.
  std::stable_partition(parts.begin(), parts.end(),
                        [](const AnswerPart& part) { return part.inside.empty(); });
  for (const AnswerPart& part : parts) add_material_part(result, part.name, part.material->name, part.share);
  result.set_parts_source(EstimatedValue::MODEL);
  const auto& kernels = facts.kernels;
  const bool marked =
      std::any_of(parts.begin(), parts.end(), [](const AnswerPart& part) { return !part.votes.empty(); });
  if (!kernels || !marked) {
    result.set_parts_reason(!kernels
                                ? "one part: it was not captured"
                                : divide_by_usual_places(answer.name, *kernels, *result.mutable_parts()));
    return;
  }
  std::vector<std::vector<float>> votes;
  for (AnswerPart& part : parts) {
    part.votes.resize(kernels->positions_m.size(), 0.0f);
    votes.push_back(std::move(part.votes));
  }
  result.set_parts_reason(
      divide_by_votes(*kernels, votes, holders_of(parts), *result.mutable_parts()).reason);
}

// Maximum deviation of friction (a factor), restitution and plasticity from those of the material, due to
// finish and wear.
constexpr double kFrictionReach = 2.0, kRestitutionReach = 0.3, kPlasticityReach = 0.4;

// Clamps a value of the answer to the reach of the material's.
double within_reach(double value, double low, double high, const char* field, const MaterialRow& material,
                    std::vector<std::string>& changes) {
  const double kept = std::clamp(value, low, high);
  if (kept != value)
    changes.push_back(format_text("%s: %.3g was changed to %.3g, the limit for %s", field, value, kept,
                                  material.name.c_str()));
  return kept;
}

}  // namespace

LogNormal log_normal_of(const Span3& span) { return {std::log(span.best), deviation(span)}; }

ObjectClasses answered_classes(const Answer& answer, const std::string& name, const ObjectFacts& facts) {
  const bool replica = answer.alternatives.empty() && answer.replica.value_or(false);
  ObjectFacts named = facts;
  named.name = (replica ? "artificial " : "") + name;
  return object_classes(named);
}

bool is_named(const ObjectClasses& classes) {
  return classes.match.row && classes.match.tail != NameMatch::Tail::AnotherThing;
}

v1::PhysicalParameters fuse_answer(const Answer& answer, const ObjectFacts& facts,
                                   const v1::PhysicalParameters& offline, std::vector<std::string>& changes) {
  v1::PhysicalParameters result = offline;
  const MaterialRow& material = *answer.parts.front().material;
  const MaterialRow* before = find_material_row(offline.material());
  const bool same_class = before && before->material_class == material.material_class;
  if (!answer.name.empty()) result.set_label(answer.name);
  result.set_material(material.name);
  if (!before || has_inside_of(*before, offline)) set_inside(material, result);
  result.set_confidence(std::min(answer.confidence, kMaxConfidence));
  set_parts(answer, facts, result, changes);
  if (answer.fill != Physics::FILL_UNKNOWN) {
    result.set_fill(answer.fill);
    result.set_fill_reason(model_says(answer));
  }

  EstimatedValue& mass = *result.mutable_mass_kg();
  if (is_locked(mass)) {
    changes.push_back("mass_g: ignored, the mass is " +
                      std::string(mass.source() == EstimatedValue::PERSON ? "the user's" : "the scene's"));
  } else {
    const FusedMass fused = fused_mass(answer, facts);
    set(mass, fused.mass_kg, kMassRange_kg, fused.reason + model_says(answer));
    if (std::abs(fused.mass_kg.best - answer.mass_kg.best) > 1e-3 * answer.mass_kg.best)
      changes.push_back(format_text("mass_g: %.4g became %.4g, fused with the usual mass of \"%s\"",
                                    answer.mass_kg.best * 1e3, fused.mass_kg.best * 1e3,
                                    answer.name.c_str()));
  }

  EstimatedValue& young = *result.mutable_youngs_modulus_pa();
  if (!is_locked(young)) {
    if (answer.youngs_modulus_pa && same_class && kYoungsRange_pa.holds(young.best())) {
      const double prior = young.best();
      set(young,
          range_of(fuse(log_normal_of(*answer.youngs_modulus_pa), log_normal_of(span_of(young)),
                        kErrorCorrelation)),
          kYoungsRange_pa,
          format_text("%.3g MPa by the model, weighted with the table's %.3g MPa; ",
                      answer.youngs_modulus_pa->best * 1e-6, prior * 1e-6) +
              material.name);
      changes.push_back(format_text("young_mpa: %.4g fused with %.4g to %.4g",
                                    answer.youngs_modulus_pa->best * 1e-6, prior * 1e-6,
                                    young.best() * 1e-6));
    } else if (answer.youngs_modulus_pa) {
      set(young, *answer.youngs_modulus_pa, kYoungsRange_pa, "by the model; " + material.name);
    } else if (!same_class) {
      set(young, material.youngs_modulus_pa, kYoungsRange_pa, material.name);
    }
  }
  EstimatedValue& structure = *result.mutable_structure_coefficient();
  if (!is_locked(structure) && answer.structure_coefficient) {
    const Span3& given = *answer.structure_coefficient;
    const Span3 spread =
        given.high > given.low ? given : Span3{given.best / 1.5, given.best, given.best * 1.5};
    set(structure, spread, kStructureRange,
        given.best < 1 ? "the model's: thin or hollow things bend more easily than their material" : "bulk");
  }
  if (!is_locked(result.plasticity())) {
    if (answer.plasticity) {
      const double kept =
          within_reach(*answer.plasticity, material.plasticity - kPlasticityReach,
                       material.plasticity + kPlasticityReach, "plasticity", material, changes);
      set(*result.mutable_plasticity(), around(kept), kUnitRange, "by the model");
    } else if (!same_class)
      set(*result.mutable_plasticity(), around(material.plasticity), kUnitRange, material.name);
  }
  if (!is_locked(result.friction()) && answer.friction) {
    const double kept = within_reach(*answer.friction, material.friction / kFrictionReach,
                                     material.friction * kFrictionReach, "friction", material, changes);
    set(*result.mutable_friction(), around(kept), kFrictionRange, "by the model");
  }
  if (!is_locked(result.restitution()) && answer.restitution) {
    const double kept =
        within_reach(*answer.restitution, material.restitution - kRestitutionReach,
                     material.restitution + kRestitutionReach, "restitution", material, changes);
    set(*result.mutable_restitution(), around(kept), kUnitRange, "by the model");
  }
  if (!same_class && !is_locked(result.poisson_ratio())) {
    set(*result.mutable_poisson_ratio(), around(material.poisson_ratio), {0, 0.49}, material.name);
  }
  if (!same_class && !is_locked(result.damping())) {
    set(*result.mutable_damping(), around(material.loss_factor), {0, 2},
        "loss factor of " + material.material_class);
  }
  const bool shell = result.fill() == Physics::SHELL || result.fill() == Physics::OPEN_SHELL;
  if (!is_locked(result.wall_thickness_m())) {
    if (const auto wall = wall_of(answer, facts); wall && shell) {
      set(*result.mutable_wall_thickness_m(), {*wall * 0.7, *wall, *wall * 1.4}, kWallRange_m,
          "by the model");
    }
  }

  const Span3 e = span_of(result.youngs_modulus_pa()), s = span_of(result.structure_coefficient());
  if (!is_locked(result.deformation_resistance())) {
    EstimatedValue& resistance = *result.mutable_deformation_resistance();
    set(resistance,
        {deformation_resistance(s.low * e.low), deformation_resistance(s.best * e.best),
         deformation_resistance(s.high * e.high)},
        kUnitRange, "from E* = s E by the paper's map");
  }
  result.set_behavior(answer.behavior);
  result.set_behavior_reason(format_text("E* = s E = %.3g MPa; ", s.best * e.best * 1e-6) +
                             model_says(answer));
  result.set_fragile(answer.fragile);
  if (answer.fragile && !is_locked(result.break_impulse_n_s())) {
    // Drop heights of 0.2, 0.5 and 1.2 m, as in the offline estimate.
    const double kg = result.mass_kg().best();
    set(*result.mutable_break_impulse_n_s(), {2.0 * kg, 3.1 * kg, 4.9 * kg},
        {0, 5 * std::max(kg, kMassRange_kg.high)}, "a fall of about half a metre");
  }
  return result;
}

}  // namespace livegs

// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/gate/gate.h"

#include <algorithm>
#include <cmath>

#include "analysis/estimate/physics_values.h"
#include "analysis/gate/prior_check.h"
#include "core/format_text.h"
#include "physics/material.h"

// Steps 7 and 8 of the gate, in weigh_answer(). fused() combines the answer with the estimate and clamps the
// values; check_prior() (prior_check.cpp) then accepts them or holds them for review. gate.h lists all steps
// with their files, and what follows a refusal.

namespace livegs {
namespace {

using v1::EstimatedValue;
using v1::Physics;

// Uncertainty factor of a guessed scale.
constexpr double kMaxSizeRatio = 2.0;
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

// Fuses two 90 % ranges: means weighted by inverse variance, in logarithms.
Span3 fuse(const Span3& a, const Span3& b) {
  const double sa = deviation(a), sb = deviation(b), wa = 1 / (sa * sa), wb = 1 / (sb * sb);
  const double mean = (wa * std::log(a.best) + wb * std::log(b.best)) / (wa + wb);
  // Ranges that disagree by more than their widths: the result covers the gap.
  const double apart = std::abs(std::log(a.best / b.best));
  const double half =
      0.5 * kRangeDeviations * std::sqrt(1 / (wa + wb)) + 0.25 * std::max(0.0, apart - sa - sb);
  return {std::exp(mean - half), std::exp(mean), std::exp(mean + half)};
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

// Takes the parts of the answer, even if there are none: the estimate's parts belong to the class assumed
// there.
void set_parts(const Answer& answer, v1::PhysicalParameters& result) {
  result.clear_parts();
  if (answer.parts.size() < 2) return;
  for (const AnswerPart& part : answer.parts) {
    add_material_part(result, part.name, part.material->name, part.share);
  }
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

// Applies the answer to all values that are not locked. E is fused with the prior only if both name the same
// material.
v1::PhysicalParameters fused(const Answer& answer, const ObjectFacts& facts,
                             const v1::PhysicalParameters& offline, std::vector<std::string>& changes) {
  v1::PhysicalParameters result = offline;
  const MaterialRow& material = *answer.parts.front().material;
  const MaterialRow* before = find_material_row(offline.material());
  const bool same_class = before && before->material_class == material.material_class;
  if (!answer.name.empty()) result.set_label(answer.name);
  result.set_material(material.name);
  if (!before || has_inside_of(*before, offline)) set_inside(material, result);
  result.set_confidence(std::min(answer.confidence, kMaxConfidence));
  set_parts(answer, result);
  if (answer.fill != Physics::FILL_UNKNOWN) {
    result.set_fill(answer.fill);
    result.set_fill_reason(model_says(answer));
  }

  EstimatedValue& mass = *result.mutable_mass_kg();
  if (is_locked(mass)) {
    changes.push_back("mass_g: ignored, the mass is " +
                      std::string(mass.source() == EstimatedValue::PERSON ? "the user's" : "the scene's"));
  } else if (kMassRange_kg.holds(mass.best())) {
    const Span3 both = fuse(answer.mass_kg, span_of(mass));
    set(mass, both, kMassRange_kg,
        format_text("%.4g g by the model and %.4g g by geometry and kind, weighted by their ranges; ",
                    answer.mass_kg.best * 1e3, mass.best() * 1e3) +
            model_says(answer));
    changes.push_back(format_text("mass_g: %.4g fused with %.4g to %.4g", answer.mass_kg.best * 1e3,
                                  offline.mass_kg().best() * 1e3, both.best * 1e3));
  } else {
    set(mass, answer.mass_kg, kMassRange_kg, model_says(answer));
  }

  EstimatedValue& young = *result.mutable_youngs_modulus_pa();
  if (!is_locked(young)) {
    if (answer.youngs_modulus_pa && same_class && kYoungsRange_pa.holds(young.best())) {
      const double prior = young.best();
      set(young, fuse(*answer.youngs_modulus_pa, span_of(young)), kYoungsRange_pa,
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

// Other statements of the answer, for the reader of the record; they affect no value.
std::vector<std::string> remarks_of(const Answer& answer, const ObjectFacts& facts) {
  std::vector<std::string> remarks;
  std::string name = "the object was identified as \"" + answer.name + "\"";
  if (answer.name_confidence) name += format_text(", with confidence %.2g", *answer.name_confidence);
  if (answer.replica) name += *answer.replica ? ", a toy or an imitation" : ", a real one";
  remarks.push_back(std::move(name));
  const double stands_m = facts.mesh.size_m.maxCoeff();
  if (answer.longest_side_m && stands_m > 0) {
    std::string size =
        format_text("assumed length %.3g m; length in the scene %.3g m", *answer.longest_side_m, stands_m);
    if (std::abs(std::log(*answer.longest_side_m / stands_m)) > std::log(kMaxSizeRatio)) {
      size += facts.scale_known ? ", which is measured"
                                : ", which is a guess; if the model is right, set the scale of the object";
    }
    remarks.push_back(std::move(size));
  }
  if (!answer.kb_ids.empty()) {
    std::string rows;
    for (const std::string& id : answer.kb_ids) rows += (rows.empty() ? "" : ", ") + id;
    remarks.push_back("it went by " + rows);
  }
  return remarks;
}

}  // namespace

Judgement weigh_answer(const Answer& answer, const ObjectFacts& facts,
                       const v1::PhysicalParameters& offline) {
  Judgement judgement;
  judgement.changes = answer.changes;
  judgement.remarks = remarks_of(answer, facts);
  judgement.proposal = fused(answer, facts, offline, judgement.changes);
  judgement.message = check_prior(answer, facts, offline, judgement.proposal);
  judgement.verdict = judgement.message.empty() ? Verdict::Accepted : Verdict::NeedsReview;
  judgement.parameters = judgement.message.empty() ? judgement.proposal : offline;
  return judgement;
}

}  // namespace livegs

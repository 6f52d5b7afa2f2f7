// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "analysis/estimate/mass_model.h"
#include "analysis/estimate/object_classes.h"
#include "analysis/estimate/stiffness_classes.h"
#include "analysis/gate/gate.h"
#include "analysis/gate/mass_bounds.h"
#include "core/text/format_text.h"

// Consistency of an answer in itself: units, physics, consistency (steps 3 to 5 of the gate, gate.h).

namespace livegs {
namespace {

using v1::Physics;

// Slack on the table's ranges, which are those of good material; products vary more.
constexpr double kMaterialSlack = 3.0;
constexpr double kMassSlack = 2.0;
// Above the densest solid.
constexpr double kMaxAnswerDensity_kg_m3 = 23000;
// Correction factors for slips of units: kilograms for grams; pascals, kilopascals or gigapascals for
// megapascals.
constexpr double kMassSlips[] = {1e3};
constexpr double kYoungsSlips[] = {1e-6, 1e-3, 1e3};

bool within(double value, const Span3& range, double slack) {
  return value >= range.low / slack && value <= range.high * slack;
}

Span3 times(const Span3& span, double factor) {
  return {span.low * factor, span.best * factor, span.high * factor};
}

// Range of the moduli of all its materials.
Span3 youngs_of(const std::vector<AnswerPart>& parts) {
  Span3 range = parts.front().material->youngs_modulus_pa;
  for (const AnswerPart& part : parts) {
    range.low = std::min(range.low, part.material->youngs_modulus_pa.low);
    range.high = std::max(range.high, part.material->youngs_modulus_pa.high);
  }
  return range;
}

// Mass of an object of the answer's materials and fill. An assembly ranges from thin walls to solid.
Span3 mass_of(const Answer& answer, const ObjectFacts& facts) {
  Span3 density = answer.parts.front().material->density_kg_m3;
  double wall_m = 0;
  for (const AnswerPart& part : answer.parts) {
    density.low = std::min(density.low, part.material->density_kg_m3.low);
    density.high = std::max(density.high, part.material->density_kg_m3.high);
    if (part.thickness_m) wall_m = std::max(wall_m, *part.thickness_m);
  }
  const bool shell = answer.fill == Physics::SHELL || answer.fill == Physics::OPEN_SHELL;
  const Span3 wall = wall_m > 0 ? Span3{0.7 * wall_m, wall_m, 1.4 * wall_m} : Span3{5e-4, 3e-3, 8e-3};
  Span3 mass = estimate_mass(density, answer.fill, wall, facts).mass_kg;
  if (!shell) {
    mass.low = std::min(mass.low, estimate_mass(density, Physics::SHELL, wall, facts).mass_kg.low);
  }
  return mass;
}

// Returns the correction factor that brings `value` into `range`, if it also explains the distance to
// `prior`; 1 if none.
double slip(double value, double prior, const Span3& range, double slack, ValueRange hard,
            std::span<const double> slips) {
  if (within(value, range, slack) || !(prior > 0)) return 1;
  for (const double factor : slips) {  // the prior itself is uncertain by a factor of three
    const double mended = value * factor, off = prior / mended;
    if (off > 1.0 / 3.0 && off < 3.0 && within(mended, range, slack) && hard.holds(mended)) return factor;
  }
  return 1;
}

void mend_units(Answer& answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline) {
  const double mass = slip(answer.mass_kg.best, offline.mass_kg().best(), mass_of(answer, facts), kMassSlack,
                           kMassRange_kg, kMassSlips);
  if (mass != 1 && kMassRange_kg.holds(answer.mass_kg.low * mass) &&
      kMassRange_kg.holds(answer.mass_kg.high * mass)) {
    answer.changes.push_back(
        format_text("mass_g.best: %g g appears to be in another unit and was read as %g g, which fits its "
                    "materials and size",
                    answer.mass_kg.best * 1e3, answer.mass_kg.best * mass * 1e3));
    answer.mass_kg = times(answer.mass_kg, mass);
    for (MassAlternative& one : answer.alternatives) one.mass_kg = times(one.mass_kg, mass);
  }
  if (!answer.youngs_modulus_pa) return;
  // The table is a better prior of a modulus than the estimate.
  const Span3 material = youngs_of(answer.parts);
  const double young = slip(answer.youngs_modulus_pa->best, std::sqrt(material.low * material.high), material,
                            kMaterialSlack, kYoungsRange_pa, kYoungsSlips);
  if (young != 1 && kYoungsRange_pa.holds(answer.youngs_modulus_pa->low * young) &&
      kYoungsRange_pa.holds(answer.youngs_modulus_pa->high * young)) {
    answer.changes.push_back(
        format_text("young_mpa.best: %g MPa appears to be in another unit and was read as %g MPa, which fits "
                    "its material",
                    answer.youngs_modulus_pa->best * 1e-6, answer.youngs_modulus_pa->best * young * 1e-6));
    answer.youngs_modulus_pa = times(*answer.youngs_modulus_pa, young);
  }
}

std::string general(double value) { return format_text("%g", value); }
std::string short_text(double value) { return format_text("%.3g", value); }

std::optional<Error> check_physics(const Answer& answer, const ObjectFacts& facts,
                                   const MessageTemplates& words) {
  const double slack = facts.scale_known ? 1.0 : kGuessedVolumeRatio;
  const double solid_m3 = std::max(facts.mesh.volume_m3, facts.mesh.hull_volume_m3);
  const double box_m3 = sorted_box_m(facts.mesh).prod();
  const double most_kg = kMaxAnswerDensity_kg_m3 * solid_m3 * slack,
               least_kg = min_mass_kg(answer, facts) / slack;
  const std::string mass_text = general(answer.mass_kg.best * 1e3);
  if (solid_m3 > 0 && answer.mass_kg.best > most_kg) {
    return invalid_data(words.say(
        "too_dense",
        {{"mass", mass_text}, {"volume", short_text(solid_m3 * 1e6)}, {"most", short_text(most_kg * 1e3)}}));
  }
  if (box_m3 > 0 && answer.mass_kg.best < least_kg) {
    return invalid_data(words.say(
        "too_light",
        {{"mass", mass_text}, {"volume", short_text(box_m3 * 1e6)}, {"least", short_text(least_kg * 1e3)}}));
  }
  return std::nullopt;
}

bool brittle(const MaterialRow& material) {
  for (const char* name :
       {"ceramic", "glass", "stone", "plastic", "wood", "food", "other", "assembly", "composite"}) {
    if (material.material_class == name) return true;
  }
  return material.fragile;
}

std::optional<Error> make_consistent(Answer& answer, const MessageTemplates& words) {
  const Span3 material = youngs_of(answer.parts);
  const std::string& name = answer.parts.front().material->name;
  if (answer.youngs_modulus_pa && !within(answer.youngs_modulus_pa->best, material, kMaterialSlack)) {
    return invalid_data(
        words.say("young_of_others", {{"young", general(answer.youngs_modulus_pa->best * 1e-6)},
                                      {"low", short_text(material.low * 1e-6)},
                                      {"high", short_text(material.high * 1e-6)},
                                      {"material", name}}));
  }
  // Without a modulus, the stiffest part is structural.
  double stiffest = 0;
  for (const AnswerPart& part : answer.parts)
    stiffest = std::max(stiffest, part.material->youngs_modulus_pa.best);
  const double stiffness = (answer.structure_coefficient ? answer.structure_coefficient->best : 1.0) *
                           (answer.youngs_modulus_pa ? answer.youngs_modulus_pa->best : stiffest);
  if (answer.behavior == Physics::ELASTIC && stiffness > kRigidStiffness_pa) {
    answer.behavior = Physics::RIGID;
    answer.changes.push_back(
        format_text("behaviour: elastic was changed to rigid, because s E = %.3g MPa is above %g MPa",
                    stiffness * 1e-6, kRigidStiffness_pa * 1e-6));
  } else if (answer.behavior == Physics::RIGID && stiffness < kSoftStiffness_pa && !answer.fragile) {
    return invalid_data(words.say("rigid_yet_soft", {{"stiffness", short_text(stiffness * 1e-6)},
                                                     {"least", general(kSoftStiffness_pa * 1e-6)}}));
  }
  if (answer.fragile) {
    const bool any = std::any_of(answer.parts.begin(), answer.parts.end(),
                                 [](const AnswerPart& part) { return brittle(*part.material); });
    if (!any) return invalid_data(words.say("fragile_yet_tough", {{"material", name}}));
    if (answer.behavior == Physics::ELASTIC) {
      answer.fragile = false;
      answer.changes.push_back("fragile: cleared, because a visibly bending material does not shatter");
    }
  }
  return std::nullopt;
}

}  // namespace

Result<Answer> validate_answer(Answer answer, const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                               const MessageTemplates& words) {
  mend_units(answer, facts, offline);
  if (auto wrong = check_physics(answer, facts, words)) return *wrong;
  if (auto wrong = make_consistent(answer, words)) return *wrong;
  return answer;
}

}  // namespace livegs

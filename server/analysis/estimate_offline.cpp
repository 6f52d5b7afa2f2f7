// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdarg>

#include "analysis/estimate.h"
#include "analysis/knowledge.h"
#include "analysis/mass_model.h"
#include "analysis/name_match.h"

// Label first, then geometry, then colour: a name with written priors halves the error that geometry alone
// leaves, and hollowness matters more than density. The steps below are in that order and each leaves a
// reason.

namespace livegs {
namespace {

using v1::EstimatedValue;

// Above this E* nothing deforms (LIVE-GS's own limit); between the two only things that are soft by nature
// do, since hands cannot bend the rest visibly and the solver would spend its substeps on nothing.
constexpr double kRigidYoungs_pa = 200e6;
constexpr double kStiffYoungs_pa = 20e6;

std::string text(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string text(const char* format, ...) {
  char buffer[320];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

void set(EstimatedValue& value, const Span3& span, std::string reason) {
  value.set_low(std::min(span.low, span.best));
  value.set_best(span.best);
  value.set_high(std::max(span.high, span.best));
  value.set_source(EstimatedValue::OFFLINE);
  value.set_reason(std::move(reason));
}

// A judgement with a relative spread, kept within [low, high].
Span3 around(double best, double spread, double low, double high) {
  return {std::max(low, best * (1 - spread)), best, std::min(high, best * (1 + spread))};
}

bool soft_by_nature(const MaterialRow& material) {
  for (const char* name : {"elastomer", "foam", "textile", "stuffed", "plant", "food"}) {
    if (material.material_class == name) return true;
  }
  return false;
}

// What an object without a telling name is taken for.
struct Guess {
  const MaterialRow* material;
  v1::Physics::Fill fill;
  Span3 wall_m, structure;
  double confidence;
  std::string reason;
};

Guess guess_by_looks(const ObjectFacts& facts) {
  const AppearanceFacts& look = facts.appearance;
  const Eigen::Vector3f& rgb = look.mean_rgb;
  const Span3 whole{1, 1, 1}, wall{1.5e-3, 3e-3, 8e-3};
  const bool open = facts.mesh.openness > 0.3;
  if (look.mean_opacity > 0 && look.mean_opacity < 0.35 && look.saturation < 0.25f) {
    return {&material_row("soda-lime glass"),
            open ? v1::Physics::OPEN_SHELL : v1::Physics::SOLID,
            wall,
            whole,
            0.3,
            text("half transparent and colourless (mean opacity %.2f)", look.mean_opacity)};
  }
  if (rgb.y() > 1.1f * rgb.x() && rgb.y() > 1.2f * rgb.z() && look.saturation > 0.25f) {
    return {&material_row("leaf"),       v1::Physics::SOLID, wall, {0.05, 0.1, 0.3}, 0.35,
            "mostly green, like foliage"};
  }
  if (rgb.x() > 1.15f * rgb.y() && rgb.y() > 1.15f * rgb.z() && look.saturation > 0.3f &&
      look.hue_spread < 0.5f) {
    return {&material_row("softwood"), v1::Physics::SOLID, wall, whole, 0.25, "brown throughout, like wood"};
  }
  if (look.saturation < 0.12f && look.gloss < 0.15f && facts.mesh.solidity > 0.5) {
    return {&material_row("plaster"), v1::Physics::SHELL, {5e-3, 12e-3, 40e-3}, whole, 0.2,
            "grey, dull and compact"};
  }
  return {&material_row("ABS"),
          open ? v1::Physics::OPEN_SHELL : v1::Physics::SHELL,
          wall,
          whole,
          0.15,
          "neither name nor looks tell; most things of no known kind are plastic shells"};
}

}  // namespace

v1::PhysicalParameters estimate_offline(const ObjectFacts& facts) {
  v1::PhysicalParameters answer;
  const NameMatch match = match_name(facts.name);
  const ObjectRow* row = match.row;
  const MaterialMatch material_match = match_material(facts.name);
  const MaterialRow* named = material_match.row;
  // "wooden" beside something that is of wood anyway adds nothing to what its kind says.
  if (row && named && !material_match.outright &&
      material_row(row->material).material_class == named->material_class) {
    named = nullptr;
  }
  Guess guess;
  if (row) {
    guess.material = named ? named : &material_row(row->material);
    guess.fill = row->fill;
    guess.wall_m = row->wall_m;
    guess.structure = row->structure_coefficient;
    guess.confidence = named ? 0.6 : 0.5;
    guess.reason = text("the name \"%s\" says %s; a %s is usually %s", facts.name.c_str(),
                        match.alias.c_str(), match.alias.c_str(), guess.material->name.c_str());
    answer.set_label(match.alias);
  } else {
    guess = guess_by_looks(facts);
    if (named) {
      guess.material = named;
      guess.confidence = 0.4;
      guess.reason = text("the name \"%s\" says %s", facts.name.c_str(), named->name.c_str());
    }
    answer.set_label("object");
  }
  if (facts.solid) {
    guess.fill = v1::Physics::SOLID;
    guess.wall_m = {};
  }
  const MaterialRow& material = *guess.material;
  answer.set_material(material.name);
  answer.set_confidence(facts.scale_known ? guess.confidence : 0.8 * guess.confidence);
  answer.set_fragile(material.fragile);
  answer.set_fill(guess.fill);
  answer.set_fill_reason(
      facts.solid ? "shapes and points are solid unless the scene says otherwise"
      : row       ? text("a %s usually is", match.alias.c_str())
                  : text("openness %.2f, filled share of the hull %.2f", facts.mesh.openness, facts.mesh.solidity));

  const Span3 structure = guess.structure;
  const Span3 stiffness{structure.low * material.youngs_modulus_pa.low,
                        structure.best * material.youngs_modulus_pa.best,
                        structure.high * material.youngs_modulus_pa.high};
  const bool soft = soft_by_nature(material);
  const bool rigid = stiffness.best > kRigidYoungs_pa || (stiffness.best > kStiffYoungs_pa && !soft);
  answer.set_behavior(rigid ? v1::Physics::RIGID : v1::Physics::ELASTIC);
  answer.set_behavior_reason(text("E* = s E = %.3g MPa, %s", stiffness.best * 1e-6,
                                  rigid ? "too stiff to deform visibly" : "soft enough to deform visibly"));

  set(*answer.mutable_wall_thickness_m(), guess.wall_m,
      guess.wall_m.best > 0 ? text("%s; the mesh's mean wall is %.3g mm",
                                   row ? "usual for its kind" : "a guess", facts.mesh.mean_wall_m * 1e3)
                            : "not a shell");
  const MassEstimate mass = estimate_mass(material.density_kg_m3, guess.fill, guess.wall_m, facts);
  set(*answer.mutable_mass_kg(), mass.mass_kg, mass.reason);
  const std::string of_material = text("%s; %s", material.name.c_str(), guess.reason.c_str());
  set(*answer.mutable_youngs_modulus_pa(), material.youngs_modulus_pa, of_material);
  set(*answer.mutable_poisson_ratio(), around(material.poisson_ratio, 0.1, 0.0, 0.49), material.name);
  set(*answer.mutable_structure_coefficient(), structure,
      structure.best < 1 ? "thin or hollow things bend more easily than their material" : "bulk");
  set(*answer.mutable_plasticity(), around(material.plasticity, 0.4, 0.0, 1.0), material.name);
  set(*answer.mutable_damping(), around(material.loss_factor, 0.5, 0.0, 2.0),
      text("loss factor of %s", material.material_class.c_str()));
  set(*answer.mutable_friction(), around(material.friction, 0.3, 0.0, 2.0),
      text("%s on common surfaces", material.name.c_str()));
  set(*answer.mutable_restitution(), around(material.restitution, 0.3, 0.0, 1.0),
      text("%s on a hard floor", material.name.c_str()));
  set(*answer.mutable_deformation_resistance(),
      {deformation_resistance(stiffness.low), deformation_resistance(stiffness.best),
       deformation_resistance(stiffness.high)},
      "from E* = s E by the paper's map");
  if (answer.fragile()) {
    // Falls of 0.2, 0.5 and 1.2 m onto a hard floor: the speeds at which such things usually break.
    const double mass_kg = answer.mass_kg().best();
    set(*answer.mutable_break_impulse_n_s(), {2.0 * mass_kg, 3.1 * mass_kg, 4.9 * mass_kg},
        text("%s things break in falls of about half a metre", material.material_class.c_str()));
  }
  return answer;
}

}  // namespace livegs

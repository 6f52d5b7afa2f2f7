// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/estimate.h"
#include "analysis/estimate/mass_model.h"
#include "analysis/knowledge/tables.h"
#include "analysis/text/message_templates.h"

namespace livegs {
namespace {

using v1::EstimatedValue;
using v1::Physics;

// Author of the values, and the wording of reasons.
struct Author {
  EstimatedValue::Source source;
  const char* whose;                 // "the scene's"
  std::string written;               // "written in the scene"
  const char *by_density, *by_fill;  // lines of mass_reasons.json
};
Author author_of(EstimatedValue::Source by) {
  const MessageTemplates& reasons = MessageTemplates::reasons();
  if (by == EstimatedValue::PERSON)
    return {by, "the user's", reasons.say("reason_person"), "reason_person_density", "reason_person_fill"};
  return {EstimatedValue::SCENE, "the scene's", reasons.say("reason_scene"), "reason_scene_density",
          "reason_scene_fill"};
}

}  // namespace

Result<v1::PhysicalParameters> merge_scene_physics(const v1::PhysicalParameters& estimated,
                                                   const Physics& written, const ObjectFacts& facts,
                                                   EstimatedValue::Source by) {
  const Author author = author_of(by);
  const auto set_value = [&](EstimatedValue& value, double number, const std::string& reason) {
    value.set_low(number);
    value.set_best(number);
    value.set_high(number);
    value.set_source(author.source);
    value.set_reason(reason);
  };
  const auto set_written = [&](EstimatedValue& value, double number) {
    set_value(value, number, author.written);
  };
  const std::string whose = author.whose;
  v1::PhysicalParameters merged = estimated;
  if (auto checked = check_scene_physics(written); !checked) return checked.error();
  if (written.has_mass_kg()) set_written(*merged.mutable_mass_kg(), written.mass_kg());
  if (written.has_wall_thickness_m())
    set_written(*merged.mutable_wall_thickness_m(), written.wall_thickness_m());
  if (written.has_youngs_modulus_pa())
    set_written(*merged.mutable_youngs_modulus_pa(), written.youngs_modulus_pa());
  if (written.has_poisson_ratio()) set_written(*merged.mutable_poisson_ratio(), written.poisson_ratio());
  if (written.has_structure_coefficient()) {
    set_written(*merged.mutable_structure_coefficient(), written.structure_coefficient());
  }
  if (written.has_plasticity()) set_written(*merged.mutable_plasticity(), written.plasticity());
  if (written.has_damping()) set_written(*merged.mutable_damping(), written.damping());
  if (written.has_break_impulse_n_s())
    set_written(*merged.mutable_break_impulse_n_s(), written.break_impulse_n_s());
  if (written.has_friction()) set_written(*merged.mutable_friction(), written.friction());
  if (written.has_restitution()) set_written(*merged.mutable_restitution(), written.restitution());
  if (written.fill() != Physics::FILL_UNKNOWN) {
    merged.set_fill(written.fill());
    merged.set_fill_reason(author.written);
  }
  if (written.has_fragile()) merged.set_fragile(written.fragile());
  if (written.has_fracture_pieces()) merged.set_fracture_pieces(written.fracture_pieces());
  if (written.interior_rgb_size() > 0) *merged.mutable_interior_rgb() = written.interior_rgb();
  if (written.parts_size() > 0) {
    *merged.mutable_parts() = written.parts();
    merged.set_parts_source(author.source);
    merged.set_parts_reason(author.written);
  }

  // A stiffness given without a structure coefficient is that of the whole body; no coefficient is guessed
  // for it.
  const bool stiffness_given = written.has_youngs_modulus_pa() || written.has_deformation_resistance();
  if (stiffness_given && !written.has_structure_coefficient()) {
    set_value(*merged.mutable_structure_coefficient(), 1.0, whose + " stiffness is that of the whole body");
  }
  if (written.has_deformation_resistance()) {
    const double stiffness = effective_youngs_modulus_pa(written.deformation_resistance());
    set_value(*merged.mutable_youngs_modulus_pa(), stiffness / merged.structure_coefficient().best(),
              "from " + whose + " deformation resistance");
  }
  const double stiffness = merged.structure_coefficient().best() * merged.youngs_modulus_pa().best();
  if (stiffness_given || written.has_structure_coefficient()) {
    set_value(*merged.mutable_deformation_resistance(), deformation_resistance(stiffness),
              "from E* = s E by the paper's map");
  }

  // The mass follows the given density, fill and wall, unless it is given itself.
  const MaterialRow* row = find_material_row(merged.material());
  const bool fill_or_wall_given = written.fill() != Physics::FILL_UNKNOWN || written.has_wall_thickness_m();
  const bool mass_estimated = merged.mass_kg().source() == EstimatedValue::OFFLINE;
  if (written.has_density_kg_m3() || (fill_or_wall_given && row && mass_estimated)) {
    const double given_kg_m3 = written.density_kg_m3(), wall = merged.wall_thickness_m().best();
    const Span3 density =
        written.has_density_kg_m3() ? Span3{given_kg_m3, given_kg_m3, given_kg_m3} : row->density_kg_m3;
    ObjectFacts known = facts;
    known.scale_known = facts.scale_known || written.has_density_kg_m3();
    const MassEstimate mass = estimate_mass(density, merged.fill(), {wall, wall, wall}, known);
    EstimatedValue& value = *merged.mutable_mass_kg();
    if (written.has_density_kg_m3()) {
      set_value(value, mass.mass_kg.best,
                MessageTemplates::reasons().say(author.by_density, {{"reason", mass.reason}}));
    } else {
      value.set_low(mass.mass_kg.low);
      value.set_best(mass.mass_kg.best);
      value.set_high(mass.mass_kg.high);
      value.set_reason(MessageTemplates::reasons().say(author.by_fill, {{"reason", mass.reason}}));
    }
  }
  if (merged.fragile() && !written.has_break_impulse_n_s() &&
      (written.has_fragile() || written.has_mass_kg() || written.has_density_kg_m3())) {
    EstimatedValue& impulse = *merged.mutable_break_impulse_n_s();
    const double mass = merged.mass_kg().best();
    impulse.set_low(2.0 * mass);
    impulse.set_best(3.1 * mass);
    impulse.set_high(4.9 * mass);
    impulse.set_source(EstimatedValue::OFFLINE);
    impulse.set_reason("a fall of about half a metre");
  }

  if (written.behavior() != Physics::AUTO) {
    merged.set_behavior(written.behavior());
    merged.set_behavior_reason(author.written);
  } else if (stiffness_given) {
    merged.set_behavior(stiffness > 200e6 ? Physics::RIGID : Physics::ELASTIC);
    merged.set_behavior_reason("from " + whose + " stiffness");
  }
  return merged;
}

}  // namespace livegs

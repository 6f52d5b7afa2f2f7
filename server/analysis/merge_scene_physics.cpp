// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "analysis/estimate.h"
#include "analysis/mass_model.h"

namespace livegs {
namespace {

using v1::EstimatedValue;
using v1::Physics;

struct Field {
  const char* name;
  bool given;
  double value, low, high;
  EstimatedValue* target;  // null for those that are worked out from others
};

void tell(EstimatedValue& value, double number, const char* reason = "written in the scene") {
  value.set_low(number);
  value.set_best(number);
  value.set_high(number);
  value.set_source(EstimatedValue::SCENE);
  value.set_reason(reason);
}

}  // namespace

Result<v1::PhysicalParameters> merge_scene_physics(const v1::PhysicalParameters& estimated,
                                                   const Physics& written, const ObjectFacts& facts) {
  v1::PhysicalParameters merged = estimated;
  const Field fields[] = {
      {"mass_kg", written.has_mass_kg(), written.mass_kg(), 1e-6, 1e6, merged.mutable_mass_kg()},
      {"density_kg_m3", written.has_density_kg_m3(), written.density_kg_m3(), 0.1, 25000, nullptr},
      {"wall_thickness_m", written.has_wall_thickness_m(), written.wall_thickness_m(), 1e-6, 10,
       merged.mutable_wall_thickness_m()},
      {"youngs_modulus_pa", written.has_youngs_modulus_pa(), written.youngs_modulus_pa(), 1, 1e12,
       merged.mutable_youngs_modulus_pa()},
      {"poisson_ratio", written.has_poisson_ratio(), written.poisson_ratio(), 0, 0.49,
       merged.mutable_poisson_ratio()},
      {"structure_coefficient", written.has_structure_coefficient(), written.structure_coefficient(), 1e-6, 1,
       merged.mutable_structure_coefficient()},
      {"deformation_resistance", written.has_deformation_resistance(), written.deformation_resistance(), 1e-6,
       1, nullptr},
      {"plasticity", written.has_plasticity(), written.plasticity(), 0, 1, merged.mutable_plasticity()},
      {"damping", written.has_damping(), written.damping(), 0, 2, merged.mutable_damping()},
      {"break_impulse_n_s", written.has_break_impulse_n_s(), written.break_impulse_n_s(), 0, 1e6,
       merged.mutable_break_impulse_n_s()},
      {"friction", written.has_friction(), written.friction(), 0, 2, merged.mutable_friction()},
      {"restitution", written.has_restitution(), written.restitution(), 0, 1, merged.mutable_restitution()},
  };
  for (const Field& field : fields) {
    if (!field.given) continue;
    if (!std::isfinite(field.value) || field.value < field.low || field.value > field.high) {
      char message[160];
      std::snprintf(message, sizeof message, "%s: is %g; it must be between %g and %g", field.name,
                    field.value, field.low, field.high);
      return invalid_argument(message);
    }
    if (field.target) tell(*field.target, field.value);
  }
  if (written.has_mass_kg() && written.has_density_kg_m3()) {
    return invalid_argument("density_kg_m3: stands beside mass_kg; give one of them");
  }
  if (written.has_youngs_modulus_pa() && written.has_deformation_resistance()) {
    return invalid_argument("deformation_resistance: stands beside youngs_modulus_pa; give one of them");
  }
  if (written.fill() != Physics::FILL_UNKNOWN) {
    merged.set_fill(written.fill());
    merged.set_fill_reason("written in the scene");
  }
  if (written.has_fragile()) merged.set_fragile(written.fragile());

  // What was told about stiffness alone means the body as a whole: no structure coefficient is guessed on top
  // of it.
  const bool stiffness_told = written.has_youngs_modulus_pa() || written.has_deformation_resistance();
  if (stiffness_told && !written.has_structure_coefficient()) {
    tell(*merged.mutable_structure_coefficient(), 1.0, "the scene's stiffness is that of the whole body");
  }
  if (written.has_deformation_resistance()) {
    const double stiffness = effective_youngs_modulus_pa(written.deformation_resistance());
    tell(*merged.mutable_youngs_modulus_pa(), stiffness / merged.structure_coefficient().best(),
         "from the scene's deformation resistance");
  }
  const double stiffness = merged.structure_coefficient().best() * merged.youngs_modulus_pa().best();
  if (stiffness_told || written.has_structure_coefficient()) {
    tell(*merged.mutable_deformation_resistance(), deformation_resistance(stiffness),
         "from E* = s E by the paper's map");
  }

  if (written.has_density_kg_m3()) {
    const double density = written.density_kg_m3(), wall = merged.wall_thickness_m().best();
    ObjectFacts known = facts;
    known.scale_known = true;
    const MassEstimate mass =
        estimate_mass({density, density, density}, merged.fill(), {wall, wall, wall}, known);
    tell(*merged.mutable_mass_kg(), mass.mass_kg.best, "from the scene's density");
    merged.mutable_mass_kg()->set_reason("from the scene's density: " + mass.reason);
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
    merged.set_behavior_reason("written in the scene");
  } else if (stiffness_told) {
    merged.set_behavior(stiffness > 200e6 ? Physics::RIGID : Physics::ELASTIC);
    merged.set_behavior_reason("from the scene's stiffness");
  }
  return merged;
}

}  // namespace livegs

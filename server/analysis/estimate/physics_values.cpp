// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/estimate/physics_values.h"

namespace livegs {

#define LIVEGS_VALUE(name)                                                         \
  {                                                                                \
#name, &v1::PhysicalParameters::name, &v1::PhysicalParameters::mutable_##name, \
        &v1::PhysicalParameters::has_##name, &v1::Physics::set_##name              \
  }

std::span<const PhysicsValue> physics_values() {
  static const PhysicsValue kValues[] = {LIVEGS_VALUE(mass_kg),
                                         LIVEGS_VALUE(youngs_modulus_pa),
                                         LIVEGS_VALUE(poisson_ratio),
                                         LIVEGS_VALUE(structure_coefficient),
                                         LIVEGS_VALUE(deformation_resistance),
                                         LIVEGS_VALUE(plasticity),
                                         LIVEGS_VALUE(damping),
                                         LIVEGS_VALUE(friction),
                                         LIVEGS_VALUE(restitution),
                                         LIVEGS_VALUE(wall_thickness_m),
                                         LIVEGS_VALUE(break_impulse_n_s)};
  return kValues;
}

#undef LIVEGS_VALUE

bool is_locked(const v1::EstimatedValue& value) {
  return value.source() == v1::EstimatedValue::SCENE || value.source() == v1::EstimatedValue::PERSON;
}

void add_material_part(v1::PhysicalParameters& parameters, const std::string& name,
                       const std::string& material, double mass_share) {
  v1::MaterialPart& part = *parameters.add_parts();
  part.set_name(name);
  part.set_material(material);
  part.set_mass_share(mass_share);
}

const char* source_name(v1::EstimatedValue::Source source) {
  switch (source) {
    case v1::EstimatedValue::OFFLINE:
      return "offline";
    case v1::EstimatedValue::MODEL:
      return "model";
    case v1::EstimatedValue::SCENE:
      return "scene";
    case v1::EstimatedValue::PERSON:
      return "person";
    case v1::EstimatedValue::DEFAULT:
      return "default";
    default:
      return "unknown";
  }
}

const char* fill_name(v1::Physics::Fill fill) {
  switch (fill) {
    case v1::Physics::SOLID:
      return "solid";
    case v1::Physics::SHELL:
      return "shell";
    case v1::Physics::OPEN_SHELL:
      return "open_shell";
    case v1::Physics::FILLED:
      return "filled";
    default:
      return "unknown";
  }
}

}  // namespace livegs

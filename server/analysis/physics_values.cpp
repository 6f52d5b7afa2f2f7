// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/physics_values.h"

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

}  // namespace livegs

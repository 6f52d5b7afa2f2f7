// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Core>
#include <algorithm>

#include "analysis/estimate.h"

namespace livegs {

Material to_material(const v1::PhysicalParameters& parameters) {
  Material material;
  switch (parameters.behavior()) {
    case v1::Physics::STATIC:
      material.behavior = Behavior::Static;
      break;
    case v1::Physics::ELASTIC:
      material.behavior = Behavior::Elastic;
      break;
    default:
      material.behavior = Behavior::Rigid;
      break;
  }
  switch (parameters.fill()) {
    case v1::Physics::SHELL:
      material.fill = Fill::Shell;
      break;
    case v1::Physics::OPEN_SHELL:
      material.fill = Fill::OpenShell;
      break;
    case v1::Physics::FILLED:
      material.fill = Fill::Filled;
      break;
    default:
      material.fill = Fill::Solid;
      break;
  }
  material.mass_kg = parameters.mass_kg().best();
  material.wall_thickness_m = parameters.wall_thickness_m().best();
  material.youngs_modulus_pa = parameters.youngs_modulus_pa().best();
  material.poisson_ratio = std::clamp(parameters.poisson_ratio().best(), 0.0, 0.49);
  material.structure_coefficient = parameters.structure_coefficient().best();
  material.plasticity = parameters.plasticity().best();
  material.loss_factor = parameters.damping().best();
  material.fragile = parameters.fragile();
  material.break_impulse_n_s = parameters.break_impulse_n_s().best();
  if (parameters.fracture_pieces() > 0) material.fracture_pieces = parameters.fracture_pieces();
  if (parameters.interior_rgb_size() == 3) {
    material.interior_rgb = Eigen::Vector3d(parameters.interior_rgb().data()).cast<float>();
  }
  material.friction = parameters.friction().best();
  material.restitution = parameters.restitution().best();
  return material;
}

}  // namespace livegs

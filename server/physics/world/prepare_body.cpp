// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/prepare_body.h"

#include "physics/collision/collision_shape.h"
#include "physics/collision/surface_points.h"
#include "physics/world/check_descriptions.h"

namespace livegs {

void prepare_body(RigidBodyDescription& description) {
  if (description.sphere_radius_m > 0.0 || !check_rigid(description)) return;
  description.shape = std::make_shared<const RigidShape>(
      mesh_shape(description.mesh, description.properties.centre_of_mass_m));
}

void prepare_body(ElasticBodyDescription& description) {
  if (!check_elastic_body(description)) return;
  description.patches =
      std::make_shared<const std::vector<SurfacePatch>>(surface_patches(description.particles));
}

}  // namespace livegs

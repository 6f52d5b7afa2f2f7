// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/elastic_body.h"

namespace livegs::study {

// Bullet's deformable body behind the seam of our own solvers, so that every scene runs it in the same
// process: the description's box in cubes of its cell width, five tetrahedra a cube, corotated linear
// elasticity with the material's own E and nu, implicit Euler with Bullet's Krylov solver as it comes. Its
// own stiffness-proportional damping is off; the loss factor is mass-proportional at the same rate as in
// `cells`. Knows gravity, point forces, fixed regions and the initial deformation. Colliders, balls, motions,
// rendering and ray casts are not connected. Fails where the particles do not fill a box of whole cells.
Result<std::unique_ptr<ElasticBody>> make_bullet_body(const ElasticBodyDescription& description,
                                                      double rate_hz, int substeps);

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/elastic_body.h"

namespace livegs::study {

// Bullet's deformable body behind the ElasticBody interface, so that every scene runs it in the same process.
// The body is a box of cubes of the cell width with five tetrahedra each, corotated linear elasticity with
// the material's E and nu, implicit Euler, and Bullet's Krylov solver with default settings. Its
// stiffness-proportional damping is off; the loss factor is mass-proportional at the same rate as in `cells`.
//
// Supports gravity, point forces, fixed regions and the initial deformation. Colliders, balls, motions,
// rendering and ray casts are not connected. Fails if the particles do not fill a box of whole cells.
Result<std::unique_ptr<ElasticBody>> make_bullet_body(const ElasticBodyDescription& description,
                                                      double rate_hz, int substeps);

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "physics/elastic_body.h"
#include "physics/rigid_body.h"
#include "physics/world.h"

namespace livegs {

// The mean force of a spring over the next `duration_s`, at the material point `arm_m` from the centre of mass (world
// axes). Damped critically for the mass at that point and evaluated implicitly (the response of the body to its own
// spring is part of the equation), so that any stiffness and mass are stable. Bounded by max_force_n.
Eigen::Vector3d spring_force(const World::Spring& spring, const RigidBody& body, const Eigen::Vector3d& arm_m,
                             double duration_s);

// The same on an elastic body. Its answer to a force is not known in closed form: stiffness acts explicitly, damping
// is critical for the whole body's mass but no more than the grasped cell can take in one substep.
Eigen::Vector3d spring_force(const World::Spring& spring, const ElasticBody& body, double mass_kg,
                             double duration_s);

}  // namespace livegs

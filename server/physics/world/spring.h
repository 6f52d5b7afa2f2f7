// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "physics/elastic_body.h"
#include "physics/world.h"

namespace livegs {

// For a solver that takes no springs (ElasticBody::takes_springs): the force of one on a material point of an
// elastic body over the next `duration_s`, bounded by max_force_n. The body's answer to it is not known in
// closed form: stiffness acts explicitly, damping, against the target's velocity, is critical for `mass_kg`;
// neither is more than the grasped cell can take in one substep.
Eigen::Vector3d spring_force(const World::Spring& spring, const Eigen::Vector3d& target_velocity_m_s,
                             const ElasticBody& body, double mass_kg, double duration_s);

}  // namespace livegs

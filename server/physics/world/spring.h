// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "physics/elastic_body.h"
#include "physics/world.h"

namespace livegs {

// Explicit spring force for solvers without implicit springs (ElasticBody::takes_springs): the force on a
// material point of an elastic body over the next `duration_s`, bounded by max_force_n. Damping against the
// target's velocity is critical for `mass_kg`. Stiffness and damping are limited to the stable range of the
// grasped cell in one substep.
Eigen::Vector3d spring_force(const World::Spring& spring, const Eigen::Vector3d& target_velocity_m_s,
                             const ElasticBody& body, double mass_kg, double duration_s);

}  // namespace livegs

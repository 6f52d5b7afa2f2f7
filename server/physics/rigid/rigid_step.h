// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

#include "physics/collider.h"
#include "physics/rigid/rigid_body.h"
#include "physics/rigid/rigid_broad_phase.h"

namespace livegs {

// External loads on a rigid body in one substep, except gravity and contact.
struct RigidLoad {
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();  // from forces, spread over the substep
  // From elastic bodies, which assume motion with the velocity after the impulse.
  Eigen::Vector3d implicit_impulse_n_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_impulse = Eigen::Vector3d::Zero();  // about the centre of mass
};

// One substep of all rigid bodies and balls (ascending id), with `loads` in the same order. Contacts are
// recomputed each substep. A sleeping body wakes on contact, with all bodies that fell asleep with it.
void step_rigid_bodies(std::span<RigidBody* const> bodies, std::span<const RigidLoad> loads,
                       std::span<const Collider> colliders, const Eigen::Vector3d& gravity_m_s2,
                       double duration_s, RigidBroadPhase& broad_phase);

}  // namespace livegs

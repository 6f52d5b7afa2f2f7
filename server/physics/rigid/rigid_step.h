// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

#include "physics/collider.h"
#include "physics/rigid/rigid_body.h"
#include "physics/rigid/rigid_broad_phase.h"

namespace livegs {

// What pushes one rigid body through a substep besides gravity and contact.
struct RigidLoad {
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();  // of forces: spread over the substep
  // Of elastic bodies, which reckon with a body that moves by the velocity after it.
  Eigen::Vector3d implicit_impulse_n_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_impulse = Eigen::Vector3d::Zero();  // about the centre of mass
};

// One substep of all rigid bodies and balls (ascending id), `loads` in the same order. Contacts are found
// again in each substep. A sleeper that is touched wakes, and with it all that fell asleep together; sleepers
// cost nothing.
void step_rigid_bodies(std::span<RigidBody* const> bodies, std::span<const RigidLoad> loads,
                       std::span<const Collider> colliders, const Eigen::Vector3d& gravity_m_s2,
                       double duration_s, RigidBroadPhase& broad_phase);

// The sleep test at the end of a tick. Bodies that touch each other sleep together, when all of them have
// been still for long enough; sleepers lose what motion they have left.
void update_sleep(std::span<RigidBody* const> bodies, double tick_s, RigidBroadPhase& broad_phase);

}  // namespace livegs

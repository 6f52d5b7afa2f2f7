// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "physics/rigid/rigid_body.h"

// What restitution may add. Each point of a contact leaves at e times the speed it came with (Newton), and
// points are taken one after the other with arms that have turned since: at e = 1 a box without friction
// gained with nearly every bounce, twenty-five times its energy in six seconds. Bodies that bounce keep what
// they had, so more than that is cut down, for all of an island by one factor, which keeps momentum.

namespace livegs {

class RestitutionEnergyLimiter {
 public:
  // At the start of the substep, before anything accelerates them.
  explicit RestitutionEnergyLimiter(std::span<RigidBody* const> bodies);
  // Right before restitution; needed where it may come at all.
  void begin();
  // After it. The part of its impulses that is left, 0 ... 1, by which velocities have been cut down already.
  double end();

 private:
  struct Motion {
    Eigen::Vector3d velocity_m_s, angular_momentum, angular_velocity_rad_s;
  };
  std::span<RigidBody* const> bodies_;
  double kinetic_j_ = 0.0;
  std::vector<Eigen::Vector3d> positions_m_;
  std::vector<Motion> before_;
  bool held_ = false;  // by hands, which add what they like
};

}  // namespace livegs

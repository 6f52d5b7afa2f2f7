// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "physics/rigid/rigid_body.h"

// Energy limit for restitution. Each contact point separates at e times its approach speed (Newton). Points
// are processed sequentially with arms that have rotated since, so kinetic energy can grow at e near 1. The
// limiter scales the restitution of a whole island by one factor, which conserves momentum.

namespace livegs {

class RestitutionEnergyLimiter {
 public:
  // Call at the start of the substep, before velocities are integrated.
  explicit RestitutionEnergyLimiter(std::span<RigidBody* const> bodies);
  // Call directly before restitution; required if any point may bounce.
  void begin();
  // Call after restitution. Scales velocities and returns the remaining fraction of the impulses, 0 … 1.
  double end();

 private:
  struct Motion {
    Eigen::Vector3d velocity_m_s, angular_momentum, angular_velocity_rad_s;
  };
  std::span<RigidBody* const> bodies_;
  double kinetic_j_ = 0.0;
  std::vector<Eigen::Vector3d> positions_m_;
  std::vector<Motion> before_;
  bool held_ = false;  // bodies are held by springs, whose work is not limited
};

}  // namespace livegs

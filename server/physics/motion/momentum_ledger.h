// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/motion/momentum.h"

namespace livegs {

// Motion of an elastic body as a whole, and the impulses on it in this substep. Moments are about the body's
// origin, those of `motion` about the centre. The inertia of `motion` is that of the material, not of the
// nodes, and its angular momentum is inertia times spin.
struct MomentumLedger {
  BodyMomentum motion;
  Eigen::Matrix3d node_inertia = Eigen::Matrix3d::Zero();  // of the nodes as point masses, about the centre
  Eigen::Matrix3d map =
      Eigen::Matrix3d::Identity();  // object frame, at rest; moments of the nodes to the material's
  Eigen::Quaterniond step_orientation = Eigen::Quaterniond::Identity();  // of the body at the current step
  // From the previous velocities, at the current positions; kg m/s and kg m²/s.
  Eigen::Vector3d momentum_before = Eigen::Vector3d::Zero(), angular_before = Eigen::Vector3d::Zero();
  // What the nodes still lack of `motion`, m/s and rad/s.
  Eigen::Vector3d velocity_correction = Eigen::Vector3d::Zero(), spin_correction = Eigen::Vector3d::Zero();
  // Of the contacts of this step, N s and N m s.
  Eigen::Vector3d contact_impulse = Eigen::Vector3d::Zero(), contact_moment = Eigen::Vector3d::Zero();
  // Received between the last step and this one, N s.
  Eigen::Vector3d between_steps_impulse = Eigen::Vector3d::Zero();
  // Lag of the centre of mass behind the contact impulses.
  Eigen::Vector3d contact_lag_m = Eigen::Vector3d::Zero();
  // At the end of the step, with the loads and, after them, the contacts; kg m/s and kg m²/s.
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();

  // After a change of the motion between steps: the next step starts from `motion`, without corrections.
  void restart() {
    momentum_before = motion.momentum;
    angular_before = motion.angular_momentum;
    for (Eigen::Vector3d* one :
         {&velocity_correction, &spin_correction, &contact_lag_m, &between_steps_impulse})
      one->setZero();
  }
};

}  // namespace livegs

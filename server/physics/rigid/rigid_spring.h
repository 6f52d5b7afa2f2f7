// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace livegs {

struct RigidBody;

// A damped spring from a point of a rigid body to a moving place in the world, and, for a hand that grabs,
// from the body's orientation to one in the world. Solved as soft rows among the contacts: the force is that
// of the positions and velocities at the end of the step, with gravity, contacts and joints in them, so that
// any stiffness and mass are stable and at rest force is stiffness times stretch. Damping is critical for the
// mass felt at the point. Both force and torque are bounded, whatever the target does.
struct RigidSpring {
  Eigen::Vector3d rest_point_m = Eigen::Vector3d::Zero();  // object frame
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero(), target_velocity_m_s = Eigen::Vector3d::Zero();
  double stiffness_n_m = 0, max_force_n = 0;
  double turn_rad_s =
      0;  // the frequency at which orientation follows, about every axis; 0: the body turns freely
  double max_torque_n_m = 0;
  Eigen::Quaterniond target_orientation = Eigen::Quaterniond::Identity();  // world from body
  Eigen::Vector3d target_spin_rad_s = Eigen::Vector3d::Zero();

  // Of the last step; the next one starts from it.
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero(), torque_n_m = Eigen::Vector3d::Zero();

  // Of the step: how the body answers, where it starts.
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero(), stretch_m = arm_m, twist_rad = arm_m;
  double rate = 0;  // N s/m: what a velocity changes the force by, within the step
  Eigen::Matrix3d turn_rate = Eigen::Matrix3d::Zero(), turn_stiffness = turn_rate;  // N m s, N m
  Eigen::Matrix<double, 6, 6> inverse = Eigen::Matrix<double, 6, 6>::Identity();
};

// The parts of one step, in the order of use: prepare, which starts with the force of the step before, then
// solve in each sweep of the push.
void prepare_spring(RigidBody& body, RigidSpring& spring, double step_s);
void solve_spring(RigidBody& body, RigidSpring& spring, double step_s);

}  // namespace livegs

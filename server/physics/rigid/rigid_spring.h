// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace livegs {

struct RigidBody;

// A damped spring from a point of a rigid body to a moving target; for grabs also from the body's orientation
// to a target orientation. Solved implicitly together with gravity, contacts and joints, so it is stable for
// any stiffness and mass. Damping is critical for the effective mass at the point. Force and torque are
// bounded for any target motion.
struct RigidSpring {
  Eigen::Vector3d rest_point_m = Eigen::Vector3d::Zero();  // object frame
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero(), target_velocity_m_s = Eigen::Vector3d::Zero();
  double stiffness_n_m = 0, max_force_n = 0;
  // Angular frequency of the orientation spring about every axis; 0: rotation is free.
  double turn_rad_s = 0;
  double max_torque_n_m = 0;
  Eigen::Quaterniond target_orientation = Eigen::Quaterniond::Identity();  // world from body
  Eigen::Vector3d target_spin_rad_s = Eigen::Vector3d::Zero();

  // Result of the last step, used for warm starting.
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero(), torque_n_m = Eigen::Vector3d::Zero();

  // Per-step data: response of the body and initial errors.
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero(), stretch_m = arm_m, twist_rad = arm_m;
  double rate = 0;  // N s/m: change of the force per velocity within the step
  Eigen::Matrix3d turn_rate = Eigen::Matrix3d::Zero(), turn_stiffness = turn_rate;  // N m s, N m
  Eigen::Matrix<double, 6, 6> inverse = Eigen::Matrix<double, 6, 6>::Identity();
};

// Phases of one step, in order: prepare_spring (applies the previous force), then solve_spring in each sweep
// of the push phase.
void prepare_spring(RigidBody& body, RigidSpring& spring, double step_s);
void solve_spring(RigidBody& body, RigidSpring& spring, double step_s);

}  // namespace livegs

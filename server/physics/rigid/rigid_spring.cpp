// SPDX-License-Identifier: GPL-3.0-or-later
// Catto 2011, Soft constraints: a spring and damper integrated implicitly is a row with a bias and a
// softness.
#include "physics/rigid/rigid_spring.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/motion/free_rotation.h"
#include "physics/motion/vector_algebra.h"
#include "physics/rigid/rigid_body.h"

namespace livegs {
namespace {

// Mean velocity of the point over the step. It includes the rotation of the arm, so that a body swinging
// about the point stays on its circle.
Eigen::Vector3d point_velocity(const RigidBody& body, const RigidSpring& spring, double step_s) {
  const Eigen::Vector3d turned = rotation_exp(step_s * body.angular_velocity_rad_s) * spring.arm_m;
  return body.velocity_m_s + (turned - spring.arm_m) / step_s;
}

void apply(RigidBody& body, const RigidSpring& spring, const Eigen::Vector3d& impulse,
           const Eigen::Vector3d& turn) {
  body.apply_impulse(impulse, spring.arm_m);
  body.apply_angular_impulse(turn);
}

}  // namespace

void prepare_spring(RigidBody& body, RigidSpring& spring, double step_s) {
  spring.arm_m = body.arm_of(spring.rest_point_m);
  spring.stretch_m = spring.target_m - body.world_from_body.position_m - spring.arm_m;
  spring.twist_rad.setZero();
  spring.turn_rate.setZero();
  spring.turn_stiffness.setZero();
  if (spring.turn_rad_s > 0.0) {
    const Eigen::AngleAxisd apart(spring.target_orientation * body.world_from_body.orientation.conjugate());
    spring.twist_rad = std::remainder(apart.angle(), 2.0 * std::numbers::pi) * apart.axis();
    // Proportional to the inertia, so that slender bodies are equally damped about each axis.
    const Eigen::Matrix3d inertia =
        rotated_tensor(body.world_from_body.orientation, body.mass_kg * body.unit_inertia_body);
    spring.turn_stiffness = spring.turn_rad_s * spring.turn_rad_s * inertia;
    spring.turn_rate = 2.0 * spring.turn_rad_s * inertia + step_s * spring.turn_stiffness;
  }
  const Eigen::Matrix3d cross = cross_matrix(spring.arm_m);
  // Response of the point's velocity and the spin to an impulse at the point and an angular impulse.
  Eigen::Matrix<double, 6, 6> response;
  response.topLeftCorner<3, 3>() =
      body.inverse_mass * Eigen::Matrix3d::Identity() - cross * body.inverse_inertia * cross;
  response.topRightCorner<3, 3>() = -cross * body.inverse_inertia;
  response.bottomLeftCorner<3, 3>() = body.inverse_inertia * cross;
  response.bottomRightCorner<3, 3>() = body.inverse_inertia;
  const auto critical = [&](double stiffness, double trace) {
    return trace > 0.0 ? 2.0 * std::sqrt(stiffness * 3.0 / trace) : 0.0;
  };
  spring.rate =
      critical(spring.stiffness_n_m, response.topLeftCorner<3, 3>().trace()) + step_s * spring.stiffness_n_m;
  Eigen::Matrix<double, 6, 6> implicit = Eigen::Matrix<double, 6, 6>::Identity();
  implicit.topRows<3>() += step_s * spring.rate * response.topRows<3>();
  implicit.bottomRows<3>() += step_s * spring.turn_rate * response.bottomRows<3>();
  spring.inverse = implicit.inverse();
  apply(body, spring, step_s * spring.force_n, step_s * spring.torque_n_m);
}

// F = k (d + h (u - v')) + c (u - v'), with the target's velocity u and the point's velocity v' including F.
// The torque is analogous.
void solve_spring(RigidBody& body, RigidSpring& spring, double step_s) {
  Eigen::Matrix<double, 6, 1> missing;
  missing.head<3>() =
      step_s *
      (spring.stiffness_n_m * spring.stretch_m +
       spring.rate * (spring.target_velocity_m_s - point_velocity(body, spring, step_s)) - spring.force_n);
  missing.tail<3>() = step_s * (spring.turn_stiffness * spring.twist_rad +
                                spring.turn_rate * (spring.target_spin_rad_s - body.angular_velocity_rad_s) -
                                spring.torque_n_m);
  const Eigen::Matrix<double, 6, 1> change = spring.inverse * missing / step_s;
  const Eigen::Vector3d force = clamp_norm(spring.force_n + change.head<3>(), spring.max_force_n);
  const Eigen::Vector3d torque = clamp_norm(spring.torque_n_m + change.tail<3>(), spring.max_torque_n_m);
  apply(body, spring, step_s * (force - spring.force_n), step_s * (torque - spring.torque_n_m));
  spring.force_n = force;
  spring.torque_n_m = torque;
}

}  // namespace livegs

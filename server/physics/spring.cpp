// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/spring.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "physics/rigid_motion.h"

namespace livegs {
namespace {

Eigen::Vector3d bounded(const Eigen::Vector3d& force, double limit) {
  const double length = force.norm();
  return length > limit ? Eigen::Vector3d(limit / length * force) : force;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

Eigen::Vector3d spring_force(const World::Spring& spring, const RigidBody& body, const Eigen::Vector3d& arm_m,
                             double duration_s) {
  const Eigen::Matrix3d cross = cross_matrix(arm_m);
  const Eigen::Matrix3d response =
      body.inverse_mass * Eigen::Matrix3d::Identity() - cross * body.inverse_inertia * cross;
  const double mass_kg = 3.0 / response.trace();
  const double damping = 2.0 * std::sqrt(spring.stiffness_n_m * mass_kg);
  // F = k (d - h v') - c v' with v' = v + h K F, where v is the mean velocity over the substep: with the arm's turn in
  // it, a body that swings round the point is held on its circle instead of being flung outwards.
  const double rate = damping + duration_s * spring.stiffness_n_m;
  const Eigen::Vector3d stretch = spring.target_m - body.world_from_body.position_m - arm_m;
  const Eigen::Vector3d turned = rotation_exp(duration_s * body.angular_velocity_rad_s) * arm_m;
  const Eigen::Vector3d velocity = body.velocity_m_s + (turned - arm_m) / duration_s;
  const Eigen::Matrix3d implicit = Eigen::Matrix3d::Identity() + duration_s * rate * response;
  return bounded(implicit.inverse() * (spring.stiffness_n_m * stretch - rate * velocity),
                 spring.max_force_n);
}

Eigen::Vector3d spring_force(const World::Spring& spring, const ElasticBody& body, double mass_kg,
                             double duration_s) {
  const ElasticAccuracy accuracy = body.accuracy();
  // What resists at the point within one substep: the mass of a cell and the stiffness of its material.
  const double cell_mass = mass_kg / std::max<double>(1.0, static_cast<double>(accuracy.cells));
  const double cell_stiffness =
      std::min(accuracy.reached_youngs_modulus_pa, body.material().effective_youngs_modulus_pa()) *
      accuracy.cell_width_m;
  const double most = 0.5 * (cell_mass / duration_s + duration_s * cell_stiffness);
  const double damping = std::min(2.0 * std::sqrt(spring.stiffness_n_m * mass_kg), most);
  const Eigen::Vector3d stretch = spring.target_m - body.world_point(spring.rest_point_m);
  return bounded(spring.stiffness_n_m * stretch - damping * body.point_velocity_m_s(spring.rest_point_m),
                 spring.max_force_n);
}

}  // namespace livegs

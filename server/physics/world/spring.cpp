// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/world/spring.h"

#include <algorithm>
#include <cmath>

namespace livegs {

Eigen::Vector3d spring_force(const World::Spring& spring, const Eigen::Vector3d& target_velocity_m_s,
                             const ElasticBody& body, double mass_kg, double duration_s) {
  const ElasticAccuracy accuracy = body.accuracy();
  // Effective mass and stiffness of the point within one substep: those of one cell.
  const double cell_mass = mass_kg / std::max<double>(1.0, static_cast<double>(accuracy.cells));
  const double cell_stiffness =
      std::min(accuracy.reached_youngs_modulus_pa, body.material().effective_youngs_modulus_pa()) *
      accuracy.cell_width_m;
  const double most = 0.5 * (cell_mass / duration_s + duration_s * cell_stiffness);
  const double stiffness = std::min(spring.stiffness_n_m, most / duration_s);
  const double damping = std::min(2.0 * std::sqrt(stiffness * mass_kg), most);
  const Eigen::Vector3d stretch = spring.target_m - body.world_point(spring.rest_point_m);
  const Eigen::Vector3d faster = target_velocity_m_s - body.point_velocity_m_s(spring.rest_point_m);
  const Eigen::Vector3d force = stiffness * stretch + damping * faster;
  const double size = force.norm();
  return size > spring.max_force_n ? Eigen::Vector3d(spring.max_force_n / size * force) : force;
}

}  // namespace livegs

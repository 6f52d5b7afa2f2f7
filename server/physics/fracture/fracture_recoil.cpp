// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/fracture/fracture_recoil.h"
#include "physics/ablation/ablation.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace livegs {

// With k the velocity change at the point per unit impulse, J reversed a closing speed u = k J / (1 + e). A
// partial impulse x has absorbed the energy u x - k x² / 2.
double impact_energy_loss_j(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                            const Eigen::Vector3d& arm_m, double borne, double restitution) {
  const double size = impulse_n_s.norm();
  if (!(size > 0.0)) return 0.0;
  const Eigen::Vector3d lever = arm_m.cross(impulse_n_s) / size;
  const double speed = 1.0 / body.mass_kg + lever.dot(body.inverse_inertia_body() * lever);
  const double given = borne * size;
  return std::max(0.0, speed * given * (size / (1.0 + restitution) - 0.5 * given));
}

void recoil(std::span<RigidBody* const> bodies, std::span<const OpenedFace> faces, double energy_j) {
  if (without(Mechanism::FractureRecoil)) return;
  struct Push {
    Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero(), angular_impulse = Eigen::Vector3d::Zero();
  };
  std::vector<Push> pushes(bodies.size());
  for (const OpenedFace& face : faces) {
    const Eigen::Vector3d impulse = face.area_m2 * face.normal;
    const auto push = [&](size_t index, const Eigen::Vector3d& by) {
      pushes[index].impulse_n_s += by;
      pushes[index].angular_impulse +=
          (face.centroid_m - bodies[index]->world_from_body.position_m).cross(by);
    };
    push(face.first, -impulse);
    push(face.second, impulse);
  }
  // The impulses sum to zero, so they exchange no energy with a common rigid motion.
  double by_unit_j = 0.0;
  for (size_t i = 0; i < bodies.size(); ++i) {
    by_unit_j += 0.5 * pushes[i].impulse_n_s.squaredNorm() / bodies[i]->mass_kg +
                 0.5 * pushes[i].angular_impulse.dot(bodies[i]->inverse_inertia * pushes[i].angular_impulse);
  }
  if (!(by_unit_j > 0.0 && energy_j > 0.0)) return;
  const double scale = std::sqrt(energy_j / by_unit_j);
  for (size_t i = 0; i < bodies.size(); ++i) {
    bodies[i]->velocity_m_s += scale * pushes[i].impulse_n_s / bodies[i]->mass_kg;
    bodies[i]->apply_angular_impulse(scale * pushes[i].angular_impulse);
  }
}

}  // namespace livegs

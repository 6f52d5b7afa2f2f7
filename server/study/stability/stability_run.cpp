// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/stability/stability_run.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/clock.h"

namespace livegs::study {

World StabilityRun::world(const Eigen::Vector3d& gravity_m_s2, bool sleep) const {
  return World({.gravity_m_s2 = gravity_m_s2, .rate_hz = rate_hz_, .sleep = sleep});
}

void StabilityRun::step(World& world, double seconds, const std::function<bool()>& after) {
  for (long i = std::lround(seconds * rate_hz_); i > 0; --i) {
    const double start_s = thread_cpu_s();
    world.step();
    cost_.cpu_s += thread_cpu_s() - start_s;
    cost_.simulated_s += 1.0 / rate_hz_;
    ++cost_.frames;
    if (after && !after()) return;
  }
}

Collider floor_of(double friction) { return Collider{PlaneShape{}, Pose{}, friction, 0.0}; }

ElasticBodyDescription soft_body(uint32_t id, const TriangleMesh& mesh, double youngs_modulus_pa,
                                 double poisson_ratio, double density_kg_m3) {
  ElasticBodyDescription body;
  body.object_id = id;
  body.particles = sample_particles(mesh);
  double volume_m3 = 0.0;
  for (const double one : body.particles.volumes_m3) volume_m3 += one;
  body.material.behavior = Behavior::Elastic;
  body.material.mass_kg = density_kg_m3 * volume_m3;
  body.material.youngs_modulus_pa = youngs_modulus_pa;
  body.material.poisson_ratio = poisson_ratio;
  body.material.restitution = 0.0;
  return body;
}

RigidBodyDescription rigid_body(uint32_t id, TriangleMesh mesh, double mass_kg) {
  RigidBodyDescription body;
  body.object_id = id;
  body.properties = solid_mass_properties(mesh);
  body.mesh = std::move(mesh);
  body.material.behavior = Behavior::Rigid;
  body.material.mass_kg = mass_kg;
  body.material.restitution = 0.0;
  return body;
}

Eigen::Quaterniond orientation_of(int number) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(
      0.7 * number, Eigen::Vector3d(std::sin(1.0 * number), std::cos(2.0 * number), 0.3).normalized()));
}

double kinetic_and_elastic_j(const BodyEnergy& energy) { return energy.kinetic_j + energy.elastic_j; }
double total_j(const BodyEnergy& energy) { return kinetic_and_elastic_j(energy) + energy.gravity_j; }

BodyState body_of(const World& world, uint32_t id) {
  for (const BodyState& body : world.bodies()) {
    if (body.object_id == id) return body;
  }
  return {};
}

}  // namespace livegs::study

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "geometry/field/sample_particles.h"
#include "physics/world.h"
#include "study/harness/setup.h"

// Worlds and bodies of the stability scenes.

namespace livegs::study {

// Counts the processor time of the steps of its worlds, on the calling thread.
class StabilityRun {
 public:
  explicit StabilityRun(double rate_hz) : rate_hz_(rate_hz) {}

  // A world of four substeps per frame at the rate of the run.
  World world(const Eigen::Vector3d& gravity_m_s2 = {0, -kGravity_m_s2, 0}, bool sleep = true) const;
  // Steps for `seconds`, rounded to whole frames; `after` is called after each and ends the run by false.
  void step(World& world, double seconds, const std::function<bool()>& after = nullptr);

  double rate_hz() const { return rate_hz_; }
  const Cost& cost() const { return cost_; }

 private:
  double rate_hz_;
  Cost cost_;
};

inline const Eigen::Vector3d kWeightless = Eigen::Vector3d::Zero();

Collider floor_of(double friction);

// Particles are sampled from the mesh as in a scene. The loss factor is the default of scenes, 0.1.
ElasticBodyDescription soft_body(uint32_t id, const TriangleMesh& mesh, double youngs_modulus_pa,
                                 double poisson_ratio = 0.3, double density_kg_m3 = 1000.0);
RigidBodyDescription rigid_body(uint32_t id, TriangleMesh mesh, double mass_kg);

// A repeatable orientation, different for each number.
Eigen::Quaterniond orientation_of(int number);

double kinetic_and_elastic_j(const BodyEnergy& energy);
double total_j(const BodyEnergy& energy);
// The only body of a rigid object. Precondition: it exists.
BodyState body_of(const World& world, uint32_t id);

}  // namespace livegs::study
